// The linearised graph: what a Gauss-Newton step solves.
#pragma once
#include <algorithm>
#include <vector>

#include "scslam/graph/factor_error.h"
#include "scslam/graph/graph_solver.h"

namespace scslam::detail {

/// H step = -gradient, with H = sum of J^T w Lambda J and gradient = sum of J^T w Lambda r.
template <int B>
struct NormalEquations {
  using Block = Eigen::Matrix<double, B, B>;
  using Part = Eigen::Matrix<double, B, 1>;
  std::vector<double> blocks, gradient;

  explicit NormalEquations(const GraphStructure& structure)
      : blocks((structure.variables + structure.pairs.size()) * B * B),
        gradient(std::size_t{structure.variables} * B) {}

  Eigen::Map<Block> block(std::uint32_t number) {
    return Eigen::Map<Block>(blocks.data() + std::size_t{number} * B * B);
  }
  Eigen::Map<Part> part(std::uint32_t v) { return Eigen::Map<Part>(gradient.data() + std::size_t{v} * B); }

  static Block reduced(const Matrix6d& full) {
    if constexpr (B == 6) {
      return full;
    } else {
      Block small;
      for (int r = 0; r < B; ++r)
        for (int c = 0; c < B; ++c) small(r, c) = full(kPlanarAxes[r], kPlanarAxes[c]);
      return small;
    }
  }
  static Part reduced(const Vector6d& full) {
    if constexpr (B == 6)
      return full;
    else
      return {full(kPlanarAxes[0]), full(kPlanarAxes[1]), full(kPlanarAxes[2])};
  }

  /// @return the cost.
  double linearise(const PoseGraph& graph, const GraphStructure& structure, const Weighting& weighting) {
    std::fill(blocks.begin(), blocks.end(), 0.0);
    std::fill(gradient.begin(), gradient.end(), 0.0);
    double cost = 0;
    for (std::size_t f = 0; f < graph.factors.size(); ++f) cost += add(graph, structure, weighting, f);
    return cost;
  }

  double add(const PoseGraph& graph, const GraphStructure& structure, const Weighting& weighting, std::size_t f) {
    const Factor& factor = graph.factors[f];
    if (!weighting.weights.empty() && weighting.weights[f] == 0) return 0;
    Matrix6d full_i, full_j;
    const Part r = reduced(factorError(factor, graph.poses[factor.i], graph.poses[factor.j], full_i, full_j));
    double weight = weighting.weights.empty() ? 1 : weighting.weights[f];
    Block information = reduced(factor.information);
    double cost = weight * r.dot(information * r);
    if (isRobust(factor.kind)) {
      const auto value = weighting.kernel(cost);
      weight *= value.weight;
      cost = value.rho;
    }
    information *= weight;
    const std::uint32_t vi = structure.variable[factor.i], vj = structure.variable[factor.j];
    const Block J_i = reduced(full_i), J_j = reduced(full_j);
    const Part weighted = information * r;
    if (vi != GraphStructure::kHeld && !isUnary(factor.kind)) {
      block(vi).noalias() += J_i.transpose() * (information * J_i);
      part(vi).noalias() += J_i.transpose() * weighted;
    }
    if (vj == GraphStructure::kHeld) return cost;
    const Block weighted_j = information * J_j;
    block(vj).noalias() += J_j.transpose() * weighted_j;
    part(vj).noalias() += J_j.transpose() * weighted;
    if (structure.block[f] == GraphStructure::kHeld) return cost;
    if (vi < vj)
      block(structure.block[f]).noalias() += J_i.transpose() * weighted_j;
    else
      block(structure.block[f]).noalias() += weighted_j.transpose() * J_i;
    return cost;
  }

  /// How much the linearised cost falls for a step that solves (H + damping diag H) step = -gradient.
  double promised(const std::vector<double>& step, double damping) {
    double decrease = 0;
    for (std::size_t k = 0; k < step.size(); ++k) {
      const double diagonal = blocks[k / B * B * B + k % B * (B + 1)];
      decrease += step[k] * (damping * diagonal * step[k] - gradient[k]);
    }
    return decrease;
  }
};

}  // namespace scslam::detail
