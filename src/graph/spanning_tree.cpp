#include <queue>
#include <tuple>

#include "scslam/graph/initial_guess.h"

namespace scslam::detail {
namespace {

using Index = std::uint32_t;

/// Factors at each node, in file order (compressed rows).
struct Adjacency {
  std::vector<std::size_t> begin;
  std::vector<Index> factor;

  Adjacency(const PoseGraph& graph, const std::vector<double>& weights) : begin(graph.poses.size() + 1) {
    const auto counts = [&](std::size_t k) {
      return isRelative(graph.factors[k].kind) && (weights.empty() || weights[k] != 0);
    };
    for (std::size_t k = 0; k < graph.factors.size(); ++k)
      if (counts(k)) ++begin[graph.factors[k].i + 1], ++begin[graph.factors[k].j + 1];
    for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
    factor.resize(begin.back());
    std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
    for (Index k = 0; k < graph.factors.size(); ++k) {
      const Factor& f = graph.factors[k];
      if (counts(k)) factor[next[f.i]++] = k, factor[next[f.j]++] = k;
    }
  }
};

/// The pose of an anchor: where it is, unless a prior (and no fixed node) says otherwise.
void placeAnchors(PoseGraph& graph, const GraphParts& parts) {
  std::vector<std::uint8_t> placed(parts.anchor.size(), 0);
  for (const Factor& factor : graph.factors) {
    const Index part = parts.part_of[factor.j];
    if (factor.kind != FactorKind::kPrior || parts.anchor[part] != factor.j || parts.held[factor.j] || placed[part])
      continue;
    placed[part] = 1;
    graph.poses[factor.j] = factor.T_i_j;
  }
}

}  // namespace

void spanningTree(PoseGraph& graph, const GraphParts& parts, bool odometry_first, const std::vector<double>& weights) {
  const Adjacency adjacency(graph, weights);
  placeAnchors(graph, parts);
  // (loops used, edges used, node): Dijkstra over lexicographic lengths; ties by node, so the tree is unique.
  using Reached = std::tuple<Index, Index, Index>;
  constexpr Index kFar = ~Index{0};
  std::vector<std::pair<Index, Index>> length(graph.poses.size(), {kFar, kFar});
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> queue;
  for (const Index v : parts.anchor) {
    length[v] = {0, 0};
    queue.emplace(0, 0, v);
  }
  while (!queue.empty()) {
    const auto [loops, edges, v] = queue.top();
    queue.pop();
    if (std::pair{loops, edges} != length[v]) continue;
    for (std::size_t k = adjacency.begin[v]; k < adjacency.begin[v + 1]; ++k) {
      const Factor& factor = graph.factors[adjacency.factor[k]];
      const Index other = factor.i == v ? factor.j : factor.i;
      const std::pair<Index, Index> longer{loops + (odometry_first && factor.kind == FactorKind::kLoop), edges + 1};
      if (longer >= length[other] || parts.held[other]) continue;
      length[other] = longer;
      graph.poses[other] = graph.poses[v] * (factor.i == v ? factor.T_i_j : factor.T_i_j.inverse());
      queue.emplace(longer.first, longer.second, other);
    }
  }
}

}  // namespace scslam::detail
