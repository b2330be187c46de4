#include "scslam/graph/graph_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scslam/graph/block_cholesky.h"
#include "scslam/graph/factor_error.h"
#include "scslam/graph/normal_equations.h"

namespace scslam::detail {
namespace {

constexpr double kMinDamping = 1e-8, kMaxDamping = 1e8;

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
    result.converged = std::max(promised, gained) <= enough || remainingDecrease(gained, gained_before) <= enough ||
                       (options.trust_model && damping == 0 && std::abs(promised - gained) <= enough);
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
