// A bound on what foreign code may allocate while it reads data nobody has checked.
#pragma once
#include <cstddef>

namespace scslam {

/// While one lives, the process may map at most `bytes` more than it has mapped now: an allocation beyond fails with
/// std::bad_alloc instead of eating the machine. Uses RLIMIT_AS, which is the process's: other threads are under the
/// same bound for that time, so keep it generous. Several may live at once (the loosest bound counts); the former limit
/// returns with the last. A stricter limit of the user's own stays in force.
/// Does nothing in builds with address or thread sanitizer, which map terabytes themselves.
class MemoryLimit {
 public:
  explicit MemoryLimit(std::size_t bytes);
  ~MemoryLimit();
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;
};

}  // namespace scslam
