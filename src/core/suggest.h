#pragma once
#include <string>
#include <vector>

namespace scslam {

/// "; did you mean 'voxel_icp'? (poses, voxel_icp)" — the nearest of `known` by edit distance, then all of them.
std::string didYouMean(const std::string& word, const std::vector<std::string>& known);

}  // namespace scslam
