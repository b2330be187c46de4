#pragma once
#include <filesystem>
#include <map>
#include <string>

#include "scslam/core/file.h"

namespace scslam::test {

/// All files below `folder` by relative name.
inline std::map<std::string, std::string> bytesOf(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      files[std::filesystem::relative(entry.path(), folder).string()] = readFile(entry.path());
  return files;
}

inline std::vector<std::string> namesIn(const std::map<std::string, std::string>& files) {
  std::vector<std::string> names;
  for (const auto& [name, bytes] : files) names.push_back(name);
  return names;
}

}  // namespace scslam::test
