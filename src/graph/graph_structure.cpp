#include <algorithm>

#include "scslam/graph/factor_error.h"
#include "scslam/graph/graph_solver.h"

namespace scslam::detail {

GraphStructure::GraphStructure(const PoseGraph& graph, const std::vector<std::uint8_t>& used)
    : parts(graphParts(graph)) {
  variable.resize(graph.poses.size(), kHeld);
  for (std::size_t v = 0; v < graph.poses.size(); ++v)
    if (!parts.held[v]) variable[v] = variables++;
  const auto pairOf = [&](const Factor& factor) {
    const auto [low, high] = std::minmax(variable[factor.i], variable[factor.j]);
    return std::pair{low, high};
  };
  const auto isBlock = [](const auto& pair) { return pair.second != kHeld && pair.first != pair.second; };
  const auto isUsed = [&](std::size_t f) { return used.empty() || used[f] != 0; };
  for (std::size_t f = 0; f < graph.factors.size(); ++f)
    if (const auto pair = pairOf(graph.factors[f]); isUsed(f) && isBlock(pair)) pairs.push_back(pair);
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  block.resize(graph.factors.size(), kHeld);
  for (std::size_t f = 0; f < graph.factors.size(); ++f)
    if (const auto pair = pairOf(graph.factors[f]); isUsed(f) && isBlock(pair))
      block[f] =
          variables + static_cast<std::uint32_t>(std::lower_bound(pairs.begin(), pairs.end(), pair) - pairs.begin());
  symbolic = std::make_shared<BlockSymbolic>(variables, pairs);
}

double Weighting::costOf(const PoseGraph& graph, std::size_t f) const {
  const Factor& factor = graph.factors[f];
  if (!weights.empty() && weights[f] == 0) return 0;
  const double s = factorChi2(graph, factor) * (weights.empty() ? 1 : weights[f]);
  return isRobust(factor.kind) ? kernel(s).rho : s;
}

double Weighting::cost(const PoseGraph& graph) const {
  double sum = 0;
  for (std::size_t f = 0; f < graph.factors.size(); ++f) sum += costOf(graph, f);
  return sum;
}

}  // namespace scslam::detail
