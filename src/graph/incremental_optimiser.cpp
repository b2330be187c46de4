#include "scslam/graph/incremental_optimiser.h"

#include <algorithm>

#include "scslam/graph/descend.h"
#include "scslam/graph/factor_error.h"

namespace scslam {
namespace {

using detail::ChainSegment;
using detail::GraphStructure;
using detail::MinimiseResult;
using detail::Weighting;

constexpr double kFirstOrder_rad = 0.1;
/// Steps in one segment at most: long drives turn the ends of longer ones beyond the first order.
constexpr std::uint32_t kLongest = 64;
constexpr int kCondensedIterations = 20;
/// What a further step must promise: the next loop will move the poses by more.
constexpr double kDecrease = 1e-3;

}  // namespace

IncrementalOptimiser::IncrementalOptimiser(const OptimiserParams& params) : params_(params) {}

double IncrementalOptimiser::gate(bool planar) const {
  return params_.gate_chi2 > 0 ? params_.gate_chi2 : defaultGate(planar);
}

RobustKernel IncrementalOptimiser::finalKernel(bool planar) const {
  if (params_.robust == "none") return RobustKernel();
  if (params_.robust == "huber") return RobustKernel(KernelKind::kHuber, gate(planar));
  return RobustKernel(params_.robust == "dcs" ? KernelKind::kDcs : KernelKind::kCauchy, gate(planar));
}

/// DCS after Cauchy: by itself it never leaves the odometry.
MinimiseResult IncrementalOptimiser::minimiseInStages(PoseGraph& graph, int max_iterations) const {
  const GraphStructure structure(graph);
  const detail::MinimiseOptions options{max_iterations, kDecrease, 1e-12, true};
  MinimiseResult result{0, true, 0};
  const auto stage = [&](const RobustKernel& kernel) {
    const MinimiseResult more = minimise(graph, structure, {kernel, {}}, options);
    result = {result.iterations + more.iterations, more.converged, more.cost};
  };
  const RobustKernel last = finalKernel(graph.planar);
  if (last.kind() == KernelKind::kDcs) stage(RobustKernel(KernelKind::kCauchy, gate(graph.planar)));
  stage(last);
  return result;
}

/// The graph of keys_ alone: what is no step, then the segments.
PoseGraph IncrementalOptimiser::condense(const PoseGraph& graph) {
  constexpr std::uint32_t kNone = ~std::uint32_t{0};
  key_of_.assign(graph.poses.size(), kNone);
  const auto use = [&](std::uint32_t node) { key_of_[node] = 0; };
  for (std::uint32_t node = 0; node < graph.poses.size(); ++node)
    if (node % kLongest == 0 || !chain_.joined(node)) use(node);
  for (const std::uint32_t node : graph.fixed) use(node);
  for (std::size_t f = 0; f < graph.factors.size(); ++f)
    if (is_step_[f] == 0) use(graph.factors[f].i), use(graph.factors[f].j);
  keys_.clear();
  for (std::uint32_t node = 0; node < graph.poses.size(); ++node) {
    if (key_of_[node] == kNone) continue;
    key_of_[node] = static_cast<std::uint32_t>(keys_.size());
    keys_.push_back(node);
  }
  PoseGraph condensed;
  if (2 * keys_.size() > graph.poses.size()) return condensed;
  segments_ = &chain_.segmentsBetween(keys_, graph.planar);
  condensed.planar = graph.planar;
  for (const std::uint32_t node : keys_) condensed.poses.push_back(graph.poses[node]);
  for (const std::uint32_t node : graph.fixed) condensed.fixed.push_back(key_of_[node]);
  for (std::size_t f = 0; f < graph.factors.size(); ++f) {
    if (is_step_[f] != 0) continue;
    condensed.factors.push_back(graph.factors[f]);
    Factor& factor = condensed.factors.back();
    factor.i = key_of_[factor.i], factor.j = key_of_[factor.j];
  }
  for (const ChainSegment& segment : *segments_)
    condensed.factors.push_back({FactorKind::kOdometry, key_of_[segment.begin], key_of_[segment.end],
                                 segment.T_begin_end, segment.information});
  return condensed;
}

/// From the keys to all poses; those behind the last key of a chain are carried along.
void IncrementalOptimiser::spread(const PoseGraph& condensed, PoseGraph& graph) const {
  for (std::size_t k = 0; k < keys_.size(); ++k) graph.poses[keys_[k]] = condensed.poses[k];
  for (const ChainSegment& segment : *segments_) segment.placeInner(graph.poses);
  for (std::size_t k = 0; k < keys_.size(); ++k) {
    const bool last = k + 1 == keys_.size();
    const auto until = last ? static_cast<std::uint32_t>(graph.poses.size()) : keys_[k + 1];
    if (!last && chain_.joined(until)) continue;  // a segment leads there
    for (std::uint32_t node = keys_[k] + 1; node < until; ++node)
      graph.poses[node] = graph.poses[node - 1] * chain_.step(node);
  }
}

bool IncrementalOptimiser::solveCondensed(PoseGraph& graph, IncrementalSummary& summary) {
  PoseGraph condensed = condense(graph);
  if (condensed.poses.empty()) return false;
  const MinimiseResult result = minimiseInStages(condensed, kCondensedIterations);
  spread(condensed, graph);
  summary.variables = keys_.size();
  summary.iterations = result.iterations;
  cost_ = result.cost;
  if (!result.converged) return false;
  return std::all_of(segments_->begin(), segments_->end(), [&](const ChainSegment& segment) {
    return segment.inner.empty() || segment.error(graph.poses).tail<3>().norm() <= kFirstOrder_rad;
  });
}

void IncrementalOptimiser::solveFull(PoseGraph& graph, IncrementalSummary& summary) {
  const MinimiseResult result = minimiseInStages(graph, params_.max_iterations);
  summary.variables = graph.poses.size();
  summary.full = true;
  summary.iterations += result.iterations;
  summary.converged = result.converged;
  cost_ = result.cost;
}

IncrementalSummary IncrementalOptimiser::solve(PoseGraph& graph) {
  IncrementalSummary summary;
  if (graph.poses.empty()) return summary;
  is_step_.clear();
  chain_.takeSteps(graph, is_step_);
  gain_ = 0;
  if (!solveCondensed(graph, summary)) solveFull(graph, summary);
  const RobustKernel kernel = finalKernel(graph.planar);
  for (std::uint32_t f = 0; f < graph.factors.size(); ++f) {
    const Factor& factor = graph.factors[f];
    if (is_step_[f] != 0) continue;
    if (isRobust(factor.kind) && kernel(factorChi2(graph, factor)).weight < 0.5)
      (factor.kind == FactorKind::kLoop ? summary.rejected_edges : summary.rejected_positions).push_back(f);
  }
  return summary;
}

bool IncrementalOptimiser::update(PoseGraph& graph, double tolerance) {
  const std::size_t known = is_step_.size();
  chain_.takeSteps(graph, is_step_);
  const RobustKernel kernel = finalKernel(graph.planar);
  for (std::size_t f = known; f < graph.factors.size(); ++f) {
    if (is_step_[f] != 0) continue;
    const double s = factorChi2(graph, graph.factors[f]);
    gain_ += isRobust(graph.factors[f].kind) ? kernel(s).rho : s;
  }
  if (gain_ <= tolerance * cost_) return false;
  solve(graph);
  return true;
}

}  // namespace scslam
