#include "scslam/graph/optimiser.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scslam/core/error.h"
#include "scslam/core/suggest.h"
#include "scslam/graph/ceres_solver.h"
#include "scslam/graph/factor_error.h"
#include "scslam/graph/initial_guess.h"

namespace scslam {
namespace {

using detail::GraphStructure;
using detail::MinimiseOptions;
using detail::MinimiseResult;
using detail::Weighting;

const std::vector<std::string> kInits = {"auto", "file", "spanning", "chordal"};
const std::vector<std::string> kRobusts = {"none", "huber", "cauchy", "dcs", "gnc"};
const std::vector<std::string> kSolvers = {"auto", "ceres"};

void checkChoice(const char* key, const std::string& value, const std::vector<std::string>& choices) {
  if (std::find(choices.begin(), choices.end(), value) == choices.end())
    throw usageError("optimiser: {} '{}' is unknown{}", key, value, didYouMean(value, choices));
}

/// The first stage. DCS and GNC go on from what Cauchy found: from the odometry alone DCS never leaves it.
KernelKind firstKernelOf(const std::string& robust) {
  if (robust == "none") return KernelKind::kNone;
  return robust == "huber" ? KernelKind::kHuber : KernelKind::kCauchy;
}

/// One optimisation from start to end; the stages share the graph's structure.
class Optimisation {
 public:
  Optimisation(PoseGraph& graph, const OptimiserParams& params)
      : graph_(graph),
        params_(params),
        structure_(graph),
        gate_(params.gate_chi2 > 0 ? params.gate_chi2 : defaultGate(graph.planar)) {
    options_ = {params.max_iterations, params.relative_decrease, 1e-12};
  }

  OptimiserSummary run() {
    summary_.chi2_initial = graphChi2(graph_);
    summary_.parts = structure_.parts.nodes.size();
    summary_.floating = describeParts(graph_, structure_.parts);
    chooseStart();
    summary_.chi2_start = graphChi2(graph_);
    if (params_.robust == "none") {
      descend(Weighting{RobustKernel(), {}});
      summary_.weights.assign(graph_.factors.size(), 1.0);
    } else {
      descendRobustly();
    }
    for (std::uint32_t f = 0; f < graph_.factors.size(); ++f)
      if (isRobust(graph_.factors[f].kind) && summary_.weights[f] < 0.5) {
        auto& rejected =
            graph_.factors[f].kind == FactorKind::kLoop ? summary_.rejected_edges : summary_.rejected_positions;
        rejected.push_back(f);
      }
    summary_.chi2_final = graphChi2(graph_);
    return summary_;
  }

 private:
  void chooseStart();
  void consider(const char* name, const std::vector<Pose>& poses, const Weighting& judge, double& lowest,
                std::vector<Pose>& best);
  void descend(const Weighting& weighting);
  void descendRobustly();
  void graduate();

  PoseGraph& graph_;
  const OptimiserParams& params_;
  GraphStructure structure_;
  double gate_;
  MinimiseOptions options_;
  OptimiserSummary summary_;
};

void Optimisation::consider(const char* name, const std::vector<Pose>& poses, const Weighting& judge, double& lowest,
                            std::vector<Pose>& best) {
  const double cost = judge.cost(graph_);
  if (std::isfinite(cost) && cost < lowest) {
    lowest = cost;
    best = graph_.poses;
    summary_.start = name;
  }
  graph_.poses = poses;
}

/// The candidate with the lowest (robust) cost; ties keep the earlier one.
void Optimisation::chooseStart() {
  const bool robust = params_.robust != "none", any = params_.init == "auto";
  const Weighting judge{RobustKernel(robust ? KernelKind::kCauchy : KernelKind::kNone, gate_), {}};
  const std::vector<Pose> given = graph_.poses;
  std::vector<Pose> best = given;
  double lowest = std::numeric_limits<double>::infinity();
  summary_.start = "file";
  if (any || params_.init == "file") consider("file", given, judge, lowest, best);
  if (any || params_.init == "spanning") {
    detail::spanningTree(graph_, structure_.parts, robust);
    consider("spanning", given, judge, lowest, best);
  }
  if (any || params_.init == "chordal")
    if (detail::chordal(graph_, structure_)) consider("chordal", given, judge, lowest, best);
  graph_.poses = best;
}

void Optimisation::descend(const Weighting& weighting) {
  MinimiseResult result;
  if (params_.solver == "auto") result = detail::minimise(graph_, structure_, weighting, options_);
  summary_.iterations += result.iterations;
  summary_.converged = result.converged;
  if (result.converged) return;
  result = detail::minimiseWithCeres(graph_, structure_, weighting, options_);
  summary_.iterations += result.iterations;
  summary_.converged = result.converged;
}

void Optimisation::descendRobustly() {
  Weighting weighting{RobustKernel(firstKernelOf(params_.robust), gate_), {}};
  descend(weighting);
  if (params_.robust == "dcs") {
    weighting.kernel = RobustKernel(KernelKind::kDcs, gate_);
    descend(weighting);
  }
  summary_.weights.assign(graph_.factors.size(), 1.0);
  for (std::size_t f = 0; f < graph_.factors.size(); ++f)
    if (isRobust(graph_.factors[f].kind))
      summary_.weights[f] = weighting.kernel(factorChi2(graph_, graph_.factors[f])).weight;
  if (params_.robust == "gnc") graduate();
}

/// Graduated non-convexity with truncated least squares, from the weights and poses that Cauchy ended with.
void Optimisation::graduate() {
  constexpr double kGrowth = 1.6, kLastMu = 1e3;
  constexpr double kRejectedWeight = 1e-9;  // not 0: a part that only false loops hold stays determined
  MinimiseOptions few = options_;
  few.max_iterations = 3;
  few.relative_decrease = 1e-4;
  for (double mu = 0.5; mu < kLastMu; mu *= kGrowth) {
    Weighting weighting{RobustKernel(), std::vector<double>(graph_.factors.size(), 1.0)};
    bool binary = true;
    for (std::size_t f = 0; f < graph_.factors.size(); ++f) {
      if (!isRobust(graph_.factors[f].kind)) continue;
      const double weight = truncatedWeight(factorChi2(graph_, graph_.factors[f]), gate_, mu);
      binary = binary && (weight == 0 || weight == 1);
      summary_.weights[f] = weight;
      weighting.weights[f] = std::max(weight, kRejectedWeight);
    }
    const bool last = binary || mu * kGrowth >= kLastMu;
    const auto result = detail::minimise(graph_, structure_, weighting, last ? options_ : few);
    summary_.iterations += result.iterations;
    summary_.converged = result.converged;
    if (last) return;
  }
}

}  // namespace

void OptimiserParams::describe(ParamVisitor& v) {
  v.field("init", init, "start: auto takes the lowest cost of file, spanning (tree) and chordal", kInits);
  v.field("robust", robust, "kernel on loop factors", kRobusts);
  v.field("gate_chi2", gate_chi2, "r' L r at which a loop has weight 1/2; 0 = 99 % quantile (6 or 3 dof)", 0, 1e9);
  v.field("max_iterations", max_iterations, "linear systems solved at most, per stage", 1, 100000);
  v.field("relative_decrease", relative_decrease, "stop when a step promises less than this share of the cost", 0, 1);
  v.field("solver", solver, "auto = own block-sparse Gauss-Newton, Ceres where that stalls; ceres = Ceres alone",
          kSolvers);
}

OptimiserSummary optimise(PoseGraph& graph, const OptimiserParams& params) {
  checkChoice("init", params.init, kInits);
  checkChoice("robust", params.robust, kRobusts);
  checkChoice("solver", params.solver, kSolvers);
  return Optimisation(graph, params).run();
}

void placeAlongSpanningTree(PoseGraph& graph) { detail::spanningTree(graph, graphParts(graph), false); }

}  // namespace scslam
