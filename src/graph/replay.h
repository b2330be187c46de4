// A graph as it would have come online: pose by pose, each with the factors to those before.
#pragma once
#include <functional>

#include "scslam/graph/pose_graph.h"

namespace scslam {

/// Builds the graph again in the order of its nodes. A new node stands where its odometry from the node before puts it,
/// else where its first factor to an earlier node does, else where it is in `graph`; then `update` may move all poses.
/// @return the whole graph (factors in the order they came in), its poses as the last update left them.
PoseGraph replayGraph(const PoseGraph& graph, const std::function<void(PoseGraph& grown)>& update);

}  // namespace scslam
