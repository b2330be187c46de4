#include "scslam/graph/graph_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scslam/graph/block_cholesky.h"
#include "scslam/graph/factor_error.h"

namespace scslam::detail {
namespace {

constexpr double kMinDamping = 1e-8, kMaxDamping = 1e8;

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

template <int B>
void applyStep(const GraphStructure& structure, const std::vector<double>& step, const std::vector<Pose>& from,
               std::vector<Pose>& to) {
  for (std::size_t v = 0; v < from.size(); ++v) {
    if (structure.variable[v] == GraphStructure::kHeld) continue;
    const double* d = step.data() + std::size_t{structure.variable[v]} * B;
    Vector6d delta = Vector6d::Zero();
    for (int k = 0; k < B; ++k) delta(B == 6 ? k : kPlanarAxes[k % 3]) = d[k];
    to[v] = retract(from[v], delta);
  }
}

/// What further steps would gain if the gains go on to shrink by the ratio of the last two (never more slowly than they
/// do near a minimum): saves the last step, which only confirms convergence.
double remainingDecrease(double gained, double gained_before) {
  const double ratio = gained / gained_before;
  return gained_before > 0 && ratio < 0.1 ? gained * ratio / (1 - ratio) : std::numeric_limits<double>::infinity();
}

template <int B>
MinimiseResult run(PoseGraph& graph, const GraphStructure& structure, const Weighting& weighting,
                   const MinimiseOptions& options) {
  NormalEquations<B> equations(structure);
  BlockCholesky<B> cholesky(structure.symbolic);
  MinimiseResult result;
  result.cost = equations.linearise(graph, structure, weighting);
  std::vector<Pose> before = graph.poses;
  std::vector<double> step;
  double damping = 0, gained_before = 0;
  while (!result.converged && result.iterations < options.max_iterations && damping <= kMaxDamping) {
    ++result.iterations;
    if (!cholesky.factor(equations.blocks, damping)) {
      damping = std::max(10 * damping, kMinDamping);
      continue;
    }
    step.resize(equations.gradient.size());
    for (std::size_t k = 0; k < step.size(); ++k) step[k] = -equations.gradient[k];
    cholesky.solve(step);
    const double promised = equations.promised(step, damping);
    applyStep<B>(structure, step, before, graph.poses);
    const double cost = weighting.cost(graph);
    if (!(cost <= result.cost)) {  // also when it is NaN
      graph.poses = before;
      result.converged = promised <= options.relative_decrease * result.cost + options.negligible;
      damping = std::max(10 * damping, 100 * kMinDamping);
      continue;
    }
    const double gained = result.cost - cost;
    result.cost = cost;
    const double enough = options.relative_decrease * cost + options.negligible;
    result.converged = std::max(promised, gained) <= enough || remainingDecrease(gained, gained_before) <= enough;
    gained_before = gained;
    if (gained < 0.25 * promised) damping = std::max(4 * damping, kMinDamping);
    if (gained > 0.75 * promised) damping = damping > kMinDamping ? damping / 10 : 0;
    before = graph.poses;
    if (!result.converged) equations.linearise(graph, structure, weighting);
  }
  return result;
}

}  // namespace

MinimiseResult minimise(PoseGraph& graph, const GraphStructure& structure, const Weighting& weighting,
                        const MinimiseOptions& options) {
  if (structure.variables == 0) return {0, true, weighting.cost(graph)};
  // Rounding accumulates over retractions: rotations are made exact once per call, which costs less than one step.
  const MinimiseResult result =
      graph.planar ? run<3>(graph, structure, weighting, options) : run<6>(graph, structure, weighting, options);
  for (std::size_t v = 0; v < graph.poses.size(); ++v)
    if (structure.variable[v] != GraphStructure::kHeld) {
      const Eigen::Quaterniond q(graph.poses[v].linear());
      graph.poses[v].linear() = q.normalized().toRotationMatrix();
    }
  return result;
}

}  // namespace scslam::detail
