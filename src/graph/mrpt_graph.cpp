#include "scslam/graph/mrpt_graph.h"

#include <algorithm>

#include "scslam/core/error.h"
#include "scslam/core/mrpt_pose.h"

namespace scslam {

mrpt::graphs::CNetworkOfPoses3DInf toMrpt(const PoseGraph& graph) {
  mrpt::graphs::CNetworkOfPoses3DInf network;
  const auto id = [&](std::uint32_t v) {
    if (graph.ids.empty()) return mrpt::graphs::TNodeID{v};
    if (graph.ids[v] < 0) throw inputError("vertex {}: MRPT's graphs have no negative ids", graph.ids[v]);
    return static_cast<mrpt::graphs::TNodeID>(graph.ids[v]);
  };
  for (std::uint32_t v = 0; v < graph.poses.size(); ++v) network.nodes[id(v)] = toMrpt(graph.poses[v]);
  if (!graph.poses.empty()) network.root = id(0);
  for (const Factor& factor : graph.factors)
    if (isRelative(factor.kind))
      network.insertEdgeAtEnd(id(factor.i), id(factor.j), toMrpt(factor.T_i_j, factor.information));
  return network;
}

PoseGraph fromMrpt(const mrpt::graphs::CNetworkOfPoses3DInf& network) {
  if (network.edges_store_inverse_poses)
    throw inputError("an MRPT graph with inverted edges (edges_store_inverse_poses) is not supported");
  PoseGraph graph;
  for (const auto& [id, pose] : network.nodes) graph.ids.push_back(static_cast<std::int64_t>(id));
  for (const auto& [ends, edge] : network.edges) {
    graph.ids.push_back(static_cast<std::int64_t>(ends.first));
    graph.ids.push_back(static_cast<std::int64_t>(ends.second));
  }
  std::sort(graph.ids.begin(), graph.ids.end());
  graph.ids.erase(std::unique(graph.ids.begin(), graph.ids.end()), graph.ids.end());
  const auto index = [&](mrpt::graphs::TNodeID id) {
    const auto it = std::lower_bound(graph.ids.begin(), graph.ids.end(), static_cast<std::int64_t>(id));
    return static_cast<std::uint32_t>(it - graph.ids.begin());
  };
  graph.poses.assign(graph.ids.size(), Pose::Identity());
  for (const auto& [id, pose] : network.nodes) graph.poses[index(id)] = fromMrpt(pose);
  for (const auto& [ends, edge] : network.edges) {
    Factor factor;
    factor.i = index(ends.first);
    factor.j = index(ends.second);
    factor.kind =
        std::max(factor.i, factor.j) - std::min(factor.i, factor.j) == 1 ? FactorKind::kOdometry : FactorKind::kLoop;
    fromMrpt(edge, factor.T_i_j, factor.information);
    graph.factors.push_back(factor);
  }
  return graph;
}

}  // namespace scslam
