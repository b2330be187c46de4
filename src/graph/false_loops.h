// False loops on purpose: how much does a robust back-end bear?
#pragma once
#include <cstdint>
#include <vector>

#include "scslam/graph/pose_graph.h"

namespace scslam {

struct FalseLoopOptions {
  std::size_t count = 0;
  std::uint64_t seed = 1;
  /// So many in a row agree with each other, as from a street that looks like another; 1 = each by itself.
  std::size_t group = 1;
};

/// Adds loops between nodes drawn at random, at least a tenth of the graph apart, that claim what a loop of the graph
/// drawn at random measured (without loops: the same place), with its information: a look-alike place. Draws that come
/// near the truth, which is where graph.poses are, are drawn again: within the graph's median odometry step and 20 deg.
/// The same seed gives the same loops. @return their factor numbers; fewer than asked for when the graph is too small.
std::vector<std::uint32_t> addFalseLoops(PoseGraph& graph, const FalseLoopOptions& options);

}  // namespace scslam
