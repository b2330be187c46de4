// Tests that write thousands of small files, each forced to the disk, do so in memory where the machine offers it.
#pragma once
#include <unistd.h>

#include <filesystem>

#include "support/support.h"

namespace scslam::test {

/// freshFolder(), in memory where that is possible; gone when the test program ends.
inline std::filesystem::path memoryFolder() {
  struct Root {
    std::filesystem::path path = "/dev/shm/scslam-test-" + std::to_string(::getpid());
    ~Root() {
      std::error_code ignored;
      std::filesystem::remove_all(path, ignored);
    }
  };
  static const Root root;
  std::filesystem::path folder = freshFolder();
  if (::access("/dev/shm", W_OK) == 0) {
    folder = root.path / folder.filename();
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
  }
  return folder;
}

}  // namespace scslam::test
