#include "scslam/graph/components.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <numeric>

namespace scslam {
namespace {

using Index = std::uint32_t;

Index find(std::vector<Index>& root, Index v) {
  while (root[v] != v) v = root[v] = root[root[v]];
  return v;
}

bool determinesPose(const Factor& prior, bool planar) {
  Matrix6d information = prior.information;
  if (planar)
    for (const int axis : {2, 3, 4}) {
      information.row(axis).setZero();
      information.col(axis).setZero();
      information(axis, axis) = 1;
    }
  const Eigen::LDLT<Matrix6d> ldlt(information);
  const auto& pivots = ldlt.vectorD();
  return ldlt.info() == Eigen::Success && pivots.minCoeff() > 1e-12 * pivots.maxCoeff();
}

void chooseAnchors(const PoseGraph& graph, GraphParts& parts) {
  std::vector<std::uint8_t> has_fixed(parts.nodes.size(), 0), has_prior(parts.nodes.size(), 0);
  for (const auto& nodes : parts.nodes) parts.anchor.push_back(nodes.front());
  for (const Factor& factor : graph.factors) {
    const Index part = parts.part_of[factor.j];
    if (factor.kind != FactorKind::kPrior || has_prior[part] || !determinesPose(factor, graph.planar)) continue;
    has_prior[part] = 1;
    parts.anchor[part] = factor.j;
  }
  for (const Index v : graph.fixed) {
    const Index part = parts.part_of[v];
    if (!has_fixed[part]) parts.anchor[part] = v;
    has_fixed[part] = 1;
    parts.held[v] = 1;
  }
  for (Index part = 0; part < parts.nodes.size(); ++part)
    if (!has_fixed[part] && !has_prior[part]) parts.held[parts.anchor[part]] = 1;
}

}  // namespace

GraphParts graphParts(const PoseGraph& graph) {
  const Index n = static_cast<Index>(graph.poses.size());
  std::vector<Index> root(n);
  std::iota(root.begin(), root.end(), Index{0});
  for (const Factor& factor : graph.factors) {
    const Index a = find(root, factor.i), b = find(root, factor.j);
    root[std::max(a, b)] = std::min(a, b);
  }
  GraphParts parts;
  parts.part_of.resize(n);
  parts.held.resize(n, 0);
  for (Index v = 0; v < n; ++v) {
    const Index first = find(root, v);
    if (first == v) {
      parts.part_of[v] = static_cast<Index>(parts.nodes.size());
      parts.nodes.emplace_back();
    } else {
      parts.part_of[v] = parts.part_of[first];
    }
    parts.nodes[parts.part_of[v]].push_back(v);
  }
  chooseAnchors(graph, parts);
  return parts;
}

std::string describeParts(const PoseGraph& graph, const GraphParts& parts) {
  if (parts.nodes.size() < 2) return {};
  const auto id = [&](Index v) { return graph.ids.empty() ? std::int64_t{v} : graph.ids[v]; };
  std::size_t alone = 0, largest = 0;
  for (const auto& nodes : parts.nodes) {
    alone += nodes.size() == 1;
    if (nodes.size() > parts.nodes[largest].size()) largest = &nodes - parts.nodes.data();
  }
  const std::size_t other = largest == 0 ? 1 : 0;
  return fmt::format(
      "the graph falls into {} unconnected parts ({} single poses; the largest has {} poses from vertex {}): each is "
      "optimised by itself and keeps the pose of its first vertex, e.g. {}; nothing fixes them to each other",
      parts.nodes.size(), alone, parts.nodes[largest].size(), id(parts.nodes[largest].front()),
      id(parts.anchor[other]));
}

}  // namespace scslam
