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
constexpr int kTakeInIterations = 5;

class GncSearch {
 public:
  GncSearch(PoseGraph& graph, const OptimiserParams& params)
      : graph_(graph),
        params_(params),
        nominal_gate_(params.gate_chi2 > 0 ? params.gate_chi2 : certainGate(graph.planar)),
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
    if (contradicted()) {
      count(minimise(graph_, structure, weighting, {10, 1e-3, 1e-12}));
      dropHopeless(weighting.kernel);
      structure = GraphStructure(graph_, used_);
      restart(structure);
    }
    for (int round = 0; round < kRounds; ++round) {
      graduate(structure);
      const bool narrower = narrowGate();
      const bool more = readmit(structure);
      if (!narrower && !more) break;
      structure = GraphStructure(graph_, used_);
      if (more) takeIn(structure);
    }
    finish();
    return result_;
  }

 private:
  void useSupported();
  void useWhatJoinsParts();
  void dropHopeless(const RobustKernel& cauchy);
  void graduate(GraphStructure& structure);
  void settle(const GraphStructure& structure);
  void graduateTruncated(const GraphStructure& structure);
  void graduateGemanMcClure(const GraphStructure& structure);
  bool contradicted() const;
  double varianceFactor() const;
  bool narrowGate();
  bool readmit(const GraphStructure& structure);
  void finish();

  /// From where the search stands, unless the factors now in use give a better start: what was false has bent the
  /// poses, what is new may be far from them.
  void restart(const GraphStructure& structure) {
    chooseStart(graph_, structure, "auto", {RobustKernel(KernelKind::kCauchy, result_.gate), mask()}, true);
  }

  /// What came back may be a lone loop after a long drift: far beyond the gate until the poses have followed it, so it
  /// is solved with before it is judged again.
  void takeIn(const GraphStructure& structure) {
    restart(structure);
    count(minimise(graph_, structure, {RobustKernel(), mask()}, {kTakeInIterations, 1e-3, 1e-12}));
  }

  /// What 99 % of the true loops lie within.
  double probableGate() const {
    return params_.gate_chi2 > 0 ? result_.gate : result_.gate / nominal_gate_ * defaultGate(graph_.planar);
  }
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
  std::vector<std::uint8_t> tried_;  ///< by factor: came back once, so that nothing goes round in circles
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

/// Is anything that is used beyond the gate?
bool GncSearch::contradicted() const {
  for (std::size_t f = 0; f < used_.size(); ++f)
    if (used_[f] != 0 && robust(f) && chi2(f) > result_.gate) return true;
  return false;
}

/// Sorts what is used into true and false; graph.poses end at the optimum of what is true.
void GncSearch::graduate(GraphStructure& structure) {
  if (!contradicted()) return settle(structure);
  if (params_.robust == "gnc")
    graduateTruncated(structure);
  else
    graduateGemanMcClure(structure);
  bool dropped = false;
  for (std::size_t f = 0; f < used_.size(); ++f)
    if (used_[f] != 0 && robust(f) && chi2(f) > result_.gate) used_[f] = 0, dropped = true;
  useWhatJoinsParts();
  structure = GraphStructure(graph_, used_);
  if (dropped) restart(structure);
  settle(structure);
}

/// To the optimum of what is used. False loops can leave the poses in a curved valley that takes a hundred short steps;
/// the chordal start, though of higher cost, lies outside of it.
void GncSearch::settle(const GraphStructure& structure) {
  constexpr int kPatience = 8;
  const Weighting weighting{RobustKernel(), mask()};
  const MinimiseOptions brief{std::min(params_.max_iterations, kPatience), params_.relative_decrease, 1e-12};
  const MinimiseResult first = minimise(graph_, structure, weighting, brief);
  count(first);
  if (first.converged) return;
  const std::vector<Pose> valley = graph_.poses;
  if (chordal(graph_, structure, weighting.weights)) {
    const MinimiseResult second = descend(graph_, structure, weighting, params_);
    count(second);
    if (second.converged && second.cost <= first.cost) return;
    graph_.poses = valley;
  }
  count(descend(graph_, structure, weighting, params_));
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

/// A-posteriori variance factor of what is used; not more than loops' upper decile allows, so that a few false ones
/// among them do not widen the gate for themselves.
double GncSearch::varianceFactor() const {
  constexpr double kRedundancy = 3;  // loops' own share of the freedom pulls their errors down by up to so much
  double sum = 0, freedom = 0;
  std::vector<double> loops;
  for (std::size_t f = 0; f < used_.size(); ++f) {
    if (used_[f] == 0) continue;
    const double s = chi2(f);
    sum += s;
    if (graph_.factors[f].kind == FactorKind::kLoop) loops.push_back(s);
    const auto diagonal = graph_.factors[f].information.diagonal();
    if (graph_.planar)
      for (const int axis : kPlanarAxes) freedom += diagonal(axis) > 0;
    else
      freedom += static_cast<double>((diagonal.array() > 0).count());
  }
  for (std::size_t v = 0; v < graph_.poses.size(); ++v) freedom -= graph_.planar ? 3 : 6;
  freedom += graph_.planar ? 3 : 6;  // the gauge
  if (freedom < 1) return 1;
  const double factor = sum / freedom;
  if (loops.size() < 10) return factor;
  return std::min(factor, kRedundancy * upperDecile(loops) / ninetyPercent(graph_.planar));
}

/// @return true when something that is used no longer passes.
bool GncSearch::narrowGate() {
  if (params_.gate_chi2 == 0) result_.gate = nominal_gate_ * std::min(1.0, kVarianceMargin * varianceFactor());
  return contradicted();
}

/// @return true when something came back.
bool GncSearch::readmit(const GraphStructure& structure) {
  std::vector<std::size_t> back, doubtful;  // the second by their innovation, which 1 % of the true ones exceed
  RelativeCovariance rest(graph_, structure, {RobustKernel(), mask()});
  for (std::size_t f = 0; f < used_.size(); ++f) {
    if (used_[f] != 0) continue;
    if (chi2(f) <= result_.gate) {
      back.push_back(f);
    } else if (tried_[f] == 0 && graph_.factors[f].kind == FactorKind::kLoop && rest.known()) {
      const double innovation = rest.innovation(graph_.factors[f]);
      if (innovation <= probableGate())
        back.push_back(f), tried_[f] = 1;
      else if (innovation <= result_.gate)
        doubtful.push_back(f);
    }
  }
  for (const std::size_t f : back) used_[f] = 1;
  // One true loop in a hundred is off by that much, not each of the few there are.
  constexpr double kChance = 0.02;
  std::size_t loops = 0;
  for (std::size_t f = 0; f < used_.size(); ++f) loops += used_[f] != 0 && robust(f);
  if (static_cast<double>(doubtful.size()) > kChance * static_cast<double>(loops)) doubtful.clear();
  for (const std::size_t f : doubtful) used_[f] = tried_[f] = 1;
  return !back.empty() || !doubtful.empty();
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
