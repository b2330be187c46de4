#pragma once
#include <filesystem>
#include <string>

namespace scslam {

/// Names the input without reading it: a hash of the names and sizes of its files, in order, and of `skip`. A resumed
/// run must agree with it.
std::string inputDigest(const std::filesystem::path& input, std::size_t skip);

}  // namespace scslam
