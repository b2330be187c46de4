#include "scslam/graph/optimiser.h"

#include <algorithm>

#include "scslam/core/error.h"
#include "scslam/core/suggest.h"
#include "scslam/graph/ceres_solver.h"
#include "scslam/graph/descend.h"
#include "scslam/graph/factor_error.h"
#include "scslam/graph/gnc.h"
#include "scslam/graph/initial_guess.h"

namespace scslam {
namespace {

using detail::GraphStructure;
using detail::MinimiseResult;
using detail::Weighting;

const std::vector<std::string> kInits = {"auto", "file", "spanning", "chordal"};
const std::vector<std::string> kRobusts = {"none", "huber", "cauchy", "dcs", "gnc", "gnc-gm"};
const std::vector<std::string> kSolvers = {"auto", "ceres"};

void checkChoice(const char* key, const std::string& value, const std::vector<std::string>& choices) {
  if (std::find(choices.begin(), choices.end(), value) == choices.end())
    throw usageError("optimiser: {} '{}' is unknown{}", key, value, didYouMean(value, choices));
}

/// The first stage. DCS goes on from what Cauchy found: from the odometry alone it never leaves it.
KernelKind firstKernelOf(const std::string& robust) {
  if (robust == "none") return KernelKind::kNone;
  return robust == "huber" ? KernelKind::kHuber : KernelKind::kCauchy;
}

bool isGnc(const std::string& robust) { return robust == "gnc" || robust == "gnc-gm"; }

/// Cauchy, Huber, DCS or no kernel at all: every factor stays.
void optimiseWithKernel(PoseGraph& graph, const OptimiserParams& params, OptimiserSummary& summary) {
  const GraphStructure structure(graph);
  const bool robust = params.robust != "none";
  const double gate = summary.gate_chi2;
  const Weighting judge{RobustKernel(robust ? KernelKind::kCauchy : KernelKind::kNone, gate), {}};
  summary.start = detail::chooseStart(graph, structure, params.init, judge, robust);
  summary.chi2_start = graphChi2(graph);
  Weighting weighting{RobustKernel(firstKernelOf(params.robust), gate), {}};
  const auto stage = [&] {
    const MinimiseResult result = detail::descend(graph, structure, weighting, params);
    summary.iterations += result.iterations;
    summary.converged = result.converged;
  };
  stage();
  if (params.robust == "dcs") {
    weighting.kernel = RobustKernel(KernelKind::kDcs, gate);
    stage();
  }
  summary.weights.assign(graph.factors.size(), 1.0);
  for (std::size_t f = 0; f < graph.factors.size(); ++f)
    if (robust && isRobust(graph.factors[f].kind))
      summary.weights[f] = weighting.kernel(factorChi2(graph, graph.factors[f])).weight;
}

void optimiseByGnc(PoseGraph& graph, const OptimiserParams& params, OptimiserSummary& summary) {
  detail::GncResult result = detail::runGnc(graph, params);
  summary.start = result.start;
  summary.chi2_start = result.chi2_start;
  summary.gate_chi2 = result.gate;
  summary.iterations = result.iterations;
  summary.converged = result.converged;
  summary.weights = std::move(result.weights);
}

}  // namespace

void OptimiserParams::describe(ParamVisitor& v) {
  v.field("init", init, "start: auto takes the lowest cost of file, spanning (tree) and chordal", kInits);
  v.field("robust", robust, "kernel on loop factors", kRobusts);
  v.field("gate_chi2", gate_chi2,
          "r' L r at which a loop has weight 1/2; 0 = 99 % quantile (6 or 3 dof); gnc: 99.999 %, narrower for modest L",
          0, 1e9);
  v.field("max_iterations", max_iterations, "linear systems solved at most, per stage", 1, 100000);
  v.field("relative_decrease", relative_decrease, "stop when a step promises less than this share of the cost", 0, 1);
  v.field("solver", solver, "auto = own block-sparse Gauss-Newton, Ceres where that stalls; ceres = Ceres alone",
          kSolvers);
}

const std::vector<std::string>& robustChoices() { return kRobusts; }

OptimiserSummary optimise(PoseGraph& graph, const OptimiserParams& params) {
  checkChoice("init", params.init, kInits);
  checkChoice("robust", params.robust, kRobusts);
  checkChoice("solver", params.solver, kSolvers);
  OptimiserSummary summary;
  summary.chi2_initial = graphChi2(graph);
  const GraphParts parts = graphParts(graph);
  summary.parts = parts.nodes.size();
  summary.floating = describeParts(graph, parts);
  summary.gate_chi2 = params.gate_chi2 > 0 ? params.gate_chi2 : defaultGate(graph.planar);
  (isGnc(params.robust) ? optimiseByGnc : optimiseWithKernel)(graph, params, summary);
  for (std::uint32_t f = 0; f < graph.factors.size(); ++f)
    if (isRobust(graph.factors[f].kind) && summary.weights[f] < 0.5)
      (graph.factors[f].kind == FactorKind::kLoop ? summary.rejected_edges : summary.rejected_positions).push_back(f);
  summary.chi2_final = graphChi2(graph);
  return summary;
}

namespace detail {

MinimiseResult descend(PoseGraph& graph, const GraphStructure& structure, const Weighting& weighting,
                       const OptimiserParams& params) {
  const MinimiseOptions options{params.max_iterations, params.relative_decrease, 1e-12};
  if (params.solver == "ceres") return minimiseWithCeres(graph, structure, weighting, options);
  MinimiseResult result = minimise(graph, structure, weighting, options);
  if (result.converged) return result;
  const int before = result.iterations;
  result = minimiseWithCeres(graph, structure, weighting, options);
  result.iterations += before;
  return result;
}

}  // namespace detail

void placeAlongSpanningTree(PoseGraph& graph) { detail::spanningTree(graph, graphParts(graph), false); }

}  // namespace scslam
