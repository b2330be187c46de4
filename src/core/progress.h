#pragma once
#include <cstddef>
#include <optional>
#include <string>

namespace scslam {

/// Progress with ETA on stderr: a bar on a terminal, a line per 10 % otherwise (per 1,000 items when the total is
/// unknown).
class Progress {
 public:
  Progress(std::string what, std::optional<std::size_t> total, bool quiet = false);
  ~Progress();
  void update(std::size_t done);
  void finish();

 private:
  void print(std::size_t done, bool last);
  std::string what_;
  std::optional<std::size_t> total_;
  bool quiet_, terminal_;
  double start_s_, last_print_s_ = 0;
  std::size_t done_ = 0, next_line_ = 0;
  bool finished_ = false;
};

}  // namespace scslam
