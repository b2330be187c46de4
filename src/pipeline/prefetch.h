// Reads the next scan while the present one is processed. What flows is a function of the input alone.
#pragma once
#include <future>
#include <optional>

#include "scslam/sensor/scan_source.h"

namespace scslam {

class Prefetcher {
 public:
  explicit Prefetcher(ScanSource& source) : source_(source) { ahead(); }
  ~Prefetcher() {
    if (next_.valid()) next_.wait();
  }
  Prefetcher(const Prefetcher&) = delete;
  Prefetcher& operator=(const Prefetcher&) = delete;

  /// Like ScanSource::next(), errors included.
  std::optional<Scan> next() {
    std::optional<Scan> scan = next_.get();
    if (scan) ahead();
    return scan;
  }

 private:
  void ahead() {
    next_ = std::async(std::launch::async, [this] { return source_.next(); });
  }
  ScanSource& source_;
  std::future<std::optional<Scan>> next_;
};

}  // namespace scslam
