// Clouds of keyframes, read back from the session folder when they are needed: memory does not grow with the drive.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>

#include "scslam/core/cloud.h"
#include "scslam/keyframe/keyframe.h"

namespace scslam {

/// Reads Scans/NNNNNN.pcd behind a least-recently-used cache. What get() returns never depends on the cache: every
/// cloud comes from its file. May be called from several threads.
class CloudStore {
 public:
  /// @param budget_bytes of clouds kept when nobody else holds them; the newest one is kept in any case.
  /// @param prepare made of each file's cloud (frame sensor; x y z intensity) before it is kept; nothing when empty.
  CloudStore(std::filesystem::path folder, std::size_t budget_bytes, std::function<Cloud(const Cloud&)> prepare = {});

  /// Cloud of keyframe k, prepared. @throw inputError when its file is missing or damaged.
  std::shared_ptr<const Cloud> get(KeyframeId k);

  std::size_t cachedBytes() const;
  std::size_t reads() const;  ///< files read so far

 private:
  struct Entry {
    KeyframeId k;
    std::shared_ptr<const Cloud> cloud;
    std::size_t bytes;
  };
  std::filesystem::path folder_;
  std::function<Cloud(const Cloud&)> prepare_;
  std::size_t budget_bytes_, cached_bytes_ = 0, reads_ = 0;
  std::list<Entry> entries_;  ///< most recently used first
  std::map<KeyframeId, std::list<Entry>::iterator> where_;
  mutable std::mutex mutex_;
};

}  // namespace scslam
