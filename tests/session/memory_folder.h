// Tests that write thousands of small files, each forced to the disk, do so in memory where the machine offers it.
#pragma once
#include <unistd.h>

#include <filesystem>

#include "support/support.h"

namespace scslam::test {

class MemoryFolder {
 public:
  MemoryFolder() {
    const std::filesystem::path memory = "/dev/shm";
    path_ = freshFolder();
    if (::access(memory.c_str(), W_OK) == 0) {
      path_ = memory / ("scslam-test-" + std::to_string(::getpid())) / path_.filename();
      std::filesystem::remove_all(path_);
      std::filesystem::create_directories(path_);
    }
  }
  ~MemoryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
    std::filesystem::remove(path_.parent_path(), ignored);
  }
  MemoryFolder(const MemoryFolder&) = delete;
  MemoryFolder& operator=(const MemoryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace scslam::test
