#include "scslam/sensor/memory_limit.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <mutex>

namespace scslam {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kUsable = false;
#else
constexpr bool kUsable = true;
#endif

std::mutex mutex;
int living = 0;
rlimit before{};

/// Bytes of address space in use; 0 when the system does not say.
rlim_t mappedBytes() {
  std::FILE* file = std::fopen("/proc/self/statm", "re");
  if (file == nullptr) return 0;
  unsigned long pages = 0;
  const bool read = std::fscanf(file, "%lu", &pages) == 1;
  std::fclose(file);
  return read ? static_cast<rlim_t>(pages) * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE)) : 0;
}

}  // namespace

MemoryLimit::MemoryLimit(std::size_t bytes) {
  if (!kUsable) return;
  const std::lock_guard lock(mutex);
  const rlim_t mapped = mappedBytes();
  rlimit now{};
  if (::getrlimit(RLIMIT_AS, &now) != 0) return;
  if (living++ == 0) before = now;
  if (mapped == 0) return;
  rlim_t wanted = mapped + bytes;
  if (living > 1) wanted = std::max(wanted, now.rlim_cur);
  now.rlim_cur = std::min(wanted, before.rlim_cur);  // RLIM_INFINITY is the largest value
  ::setrlimit(RLIMIT_AS, &now);
}

MemoryLimit::~MemoryLimit() {
  if (!kUsable) return;
  const std::lock_guard lock(mutex);
  if (living > 0 && --living == 0) ::setrlimit(RLIMIT_AS, &before);
}

}  // namespace scslam
