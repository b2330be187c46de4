#include "scslam/graph/replay.h"

#include <algorithm>

namespace scslam {
namespace {

/// By later node, in file order.
std::vector<std::vector<std::uint32_t>> factorsByArrival(const PoseGraph& graph) {
  std::vector<std::vector<std::uint32_t>> arriving(graph.poses.size());
  for (std::uint32_t f = 0; f < graph.factors.size(); ++f)
    arriving[std::max(graph.factors[f].i, graph.factors[f].j)].push_back(f);
  return arriving;
}

Pose placed(const PoseGraph& grown, std::uint32_t node, const std::vector<std::uint32_t>& arriving,
            const PoseGraph& graph) {
  const Factor* by = nullptr;
  for (const std::uint32_t f : arriving) {
    const Factor& factor = graph.factors[f];
    if (!isRelative(factor.kind)) continue;
    const bool step = factor.kind == FactorKind::kOdometry && std::min(factor.i, factor.j) + 1 == node;
    if (by == nullptr || step) by = &factor;
    if (step) break;
  }
  if (by == nullptr) return graph.poses[node];
  return by->j == node ? grown.poses[by->i] * by->T_i_j : grown.poses[by->j] * by->T_i_j.inverse();
}

}  // namespace

PoseGraph replayGraph(const PoseGraph& graph, const std::function<void(PoseGraph& grown)>& update) {
  const auto arriving = factorsByArrival(graph);
  PoseGraph grown;
  grown.planar = graph.planar;
  grown.poses.reserve(graph.poses.size());
  grown.factors.reserve(graph.factors.size());
  for (std::uint32_t node = 0; node < graph.poses.size(); ++node) {
    grown.poses.push_back(placed(grown, node, arriving[node], graph));
    if (!graph.ids.empty()) grown.ids.push_back(graph.ids[node]);
    if (std::find(graph.fixed.begin(), graph.fixed.end(), node) != graph.fixed.end()) {
      grown.fixed.push_back(node);
      grown.poses.back() = graph.poses[node];
    }
    for (const std::uint32_t f : arriving[node]) grown.factors.push_back(graph.factors[f]);
    update(grown);
  }
  return grown;
}

}  // namespace scslam
