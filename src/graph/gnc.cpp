#include "scslam/graph/gnc.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "scslam/graph/descend.h"
#include "scslam/graph/factor_error.h"
#include "scslam/graph/initial_guess.h"
#include "scslam/graph/loop_support.h"
#include "scslam/graph/relative_covariance.h"

namespace scslam::detail {
namespace {

constexpr int kRounds = 8;

class GncSearch {
 public:
  GncSearch(PoseGraph& graph, const OptimiserParams& params)
      : graph_(graph),
        params_(params),
        nominal_gate_(params.gate_chi2 > 0 ? params.gate_chi2 : defaultGate(graph.planar)),
        used_(graph.factors.size(), 1),
        tried_(graph.factors.size(), 0) {
    result_.gate = nominal_gate_;
  }

  GncResult run() {
    useSupported();
    GraphStructure structure(graph_, used_);
    Weighting weighting{RobustKernel(KernelKind::kCauchy, result_.gate), mask()};
    result_.start = chooseStart(graph_, structure, params_.init, weighting, true);
    result_.chi2_start = graphChi2(graph_);
    count(minimise(graph_, structure, weighting, {10, 1e-3, 1e-12}));
    dropHopeless(weighting.kernel);
    structure = GraphStructure(graph_, used_);
    for (int round = 0; round < kRounds; ++round) {
      graduate(structure);
      const bool narrower = narrowGate();
      const bool more = readmit(structure);
      if (!narrower && !more) break;
      structure = GraphStructure(graph_, used_);
    }
    finish();
    return result_;
  }

 private:
  void useSupported();
  void useWhatJoinsParts();
  void dropHopeless(const RobustKernel& cauchy);
  void graduate(GraphStructure& structure);
  void graduateTruncated(const GraphStructure& structure);
  void graduateGemanMcClure(const GraphStructure& structure);
  bool narrowGate();
  bool readmit(const GraphStructure& structure);
  void finish();

  std::vector<double> mask() const { return {used_.begin(), used_.end()}; }
  bool robust(std::size_t f) const { return isRobust(graph_.factors[f].kind); }
  double chi2(std::size_t f) const { return factorChi2(graph_, graph_.factors[f]); }
  void count(const MinimiseResult& result) {
    result_.iterations += result.iterations;
    result_.converged = result.converged;
  }

  PoseGraph& graph_;
  const OptimiserParams& params_;
  const double nominal_gate_;
  std::vector<std::uint8_t> used_;   ///< by factor: part of what is solved
  std::vector<std::uint8_t> tried_;  ///< by factor: came back once on its innovation
  GncResult result_;
};

void GncSearch::useSupported() {
  const OdometryChain chain(graph_);
  const LoopSupport support = loopSupport(graph_, chain);
  for (std::size_t f = 0; f < used_.size(); ++f)
    if (graph_.factors[f].kind == FactorKind::kLoop) used_[f] = support.trusted[f];
  if (params_.gate_chi2 == 0) result_.gate *= std::min(1.0, kVarianceMargin * support.variance_factor);
  useWhatJoinsParts();
}

/// Nothing contradicts what alone holds two parts together: all loops between parts that nothing else joins are used.
void GncSearch::useWhatJoinsParts() {
  std::vector<std::uint32_t> root(graph_.poses.size());
  std::iota(root.begin(), root.end(), 0U);
  const auto find = [&](std::uint32_t v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  for (std::size_t f = 0; f < used_.size(); ++f) {
    const Factor& factor = graph_.factors[f];
    if (used_[f] != 0) root[find(factor.i)] = find(factor.j);
  }
  for (std::size_t f = 0; f < used_.size(); ++f)
    if (find(graph_.factors[f].i) != find(graph_.factors[f].j)) used_[f] = 1;
}

/// What Cauchy left far outside need not cost fill-in any more; it comes back if it fits the solution.
void GncSearch::dropHopeless(const RobustKernel& cauchy) {
  constexpr double kHopeless = 0.1;
  for (std::size_t f = 0; f < used_.size(); ++f)
    if (used_[f] != 0 && robust(f) && cauchy(chi2(f)).weight < kHopeless) used_[f] = 0;
  useWhatJoinsParts();
}

/// Sorts what is used into true and false; graph.poses end at the optimum of what is true.
void GncSearch::graduate(GraphStructure& structure) {
  if (params_.robust == "gnc")
    graduateTruncated(structure);
  else
    graduateGemanMcClure(structure);
  for (std::size_t f = 0; f < used_.size(); ++f)
    if (used_[f] != 0 && robust(f) && chi2(f) > result_.gate) used_[f] = 0;
  useWhatJoinsParts();
  structure = GraphStructure(graph_, used_);
  count(descend(graph_, structure, {RobustKernel(), mask()}, params_));
}

void GncSearch::graduateTruncated(const GraphStructure& structure) {
  constexpr double kGrowth = 1.6, kLastMu = 1e3;
  MinimiseOptions few;
  few.max_iterations = 2;
  few.relative_decrease = 1e-3;
  Weighting weighting{RobustKernel(), mask()};
  for (double mu = 0.5; mu < kLastMu; mu *= kGrowth) {
    bool binary = true;
    for (std::size_t f = 0; f < used_.size(); ++f) {
      if (used_[f] == 0 || !robust(f)) continue;
      const double weight = truncatedWeight(chi2(f), result_.gate, mu);
      binary = binary && (weight == 0 || weight == 1);
      weighting.weights[f] = std::max(weight, 1e-9);  // not 0: a part that only false loops hold stays determined
    }
    if (binary) return;
    count(minimise(graph_, structure, weighting, few));
  }
}

void GncSearch::graduateGemanMcClure(const GraphStructure& structure) {
  MinimiseOptions few;
  few.max_iterations = 2;
  few.relative_decrease = 1e-3;
  double worst = 0;
  for (std::size_t f = 0; f < used_.size(); ++f)
    if (used_[f] != 0 && robust(f)) worst = std::max(worst, chi2(f));
  for (double mu = std::clamp(2 * worst / result_.gate, 1.0, 1e4); mu > 1; mu = std::max(1.0, mu / 2))
    count(minimise(graph_, structure, {RobustKernel(KernelKind::kGemanMcClure, result_.gate * mu), mask()}, few));
  count(minimise(graph_, structure, {RobustKernel(KernelKind::kGemanMcClure, result_.gate), mask()}, few));
}

/// @return true when something that is used no longer passes.
bool GncSearch::narrowGate() {
  if (params_.gate_chi2 > 0) return false;
  double sum = 0, freedom = 0;
  for (std::size_t f = 0; f < used_.size(); ++f) {
    if (used_[f] == 0) continue;
    sum += chi2(f);
    const auto diagonal = graph_.factors[f].information.diagonal();
    if (graph_.planar)
      for (const int axis : kPlanarAxes) freedom += diagonal(axis) > 0;
    else
      freedom += static_cast<double>((diagonal.array() > 0).count());
  }
  for (std::size_t v = 0; v < graph_.poses.size(); ++v) freedom -= graph_.planar ? 3 : 6;
  freedom += graph_.planar ? 3 : 6;  // the gauge
  if (freedom < 1) return false;
  result_.gate = nominal_gate_ * std::min(1.0, kVarianceMargin * sum / freedom);
  for (std::size_t f = 0; f < used_.size(); ++f)
    if (used_[f] != 0 && robust(f) && chi2(f) > result_.gate) return true;
  return false;
}

/// @return true when something came back.
bool GncSearch::readmit(const GraphStructure& structure) {
  bool any = false;
  RelativeCovariance rest(graph_, structure, {RobustKernel(), mask()});
  for (std::size_t f = 0; f < used_.size(); ++f) {
    if (used_[f] != 0) continue;
    bool back = chi2(f) <= result_.gate;
    if (!back && tried_[f] == 0 && graph_.factors[f].kind == FactorKind::kLoop && rest.known()) {
      back = rest.innovation(graph_.factors[f]) <= result_.gate;
      tried_[f] = back;
    }
    used_[f] = back;
    any = any || back;
  }
  return any;
}

void GncSearch::finish() {
  result_.weights = mask();
  if (params_.robust == "gnc") return;
  const RobustKernel kernel(KernelKind::kGemanMcClure, result_.gate);
  count(descend(graph_, GraphStructure(graph_, used_), {kernel, mask()}, params_));
  for (std::size_t f = 0; f < used_.size(); ++f)
    if (used_[f] != 0 && robust(f)) result_.weights[f] = kernel(chi2(f)).weight;
}

}  // namespace

GncResult runGnc(PoseGraph& graph, const OptimiserParams& params) { return GncSearch(graph, params).run(); }

}  // namespace scslam::detail
