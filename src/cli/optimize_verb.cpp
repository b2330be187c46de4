// scslam optimize: the back-end on a public graph.
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/log.h"
#include "scslam/graph/factor_error.h"
#include "scslam/graph/g2o.h"
#include "scslam/graph/incremental_optimiser.h"
#include "scslam/graph/optimiser.h"
#include "scslam/graph/replay.h"
#include "verb.h"

namespace scslam::cli {
namespace {

struct Options {
  std::string input, output;
  OptimiserParams params;
  bool incremental = false, json = false;
};

void printJson(const PoseGraph& graph, const OptimiserSummary& summary, double seconds) {
  nlohmann::ordered_json rejected = nlohmann::ordered_json::array();
  for (const std::uint32_t f : summary.rejected_edges)
    rejected.push_back({graph.ids[graph.factors[f].i], graph.ids[graph.factors[f].j]});
  const nlohmann::ordered_json result = {
      {"poses", graph.poses.size()},      {"edges", graph.factors.size()},    {"chi2_initial", summary.chi2_initial},
      {"chi2_final", summary.chi2_final}, {"iterations", summary.iterations}, {"seconds", seconds},
      {"rejected_edges", rejected}};
  fmt::print("{}\n", result.dump());
}

void printTable(const PoseGraph& graph, const OptimiserSummary& summary, double seconds) {
  fmt::print(
      "poses          {}\nedges          {}\nchi2 initial   {:.8g}\nstart          {} (chi2 {:.8g})\n"
      "chi2 final     {:.8g}\niterations     {}{}\nseconds        {:.3f}\n",
      graph.poses.size(), graph.factors.size(), summary.chi2_initial, summary.start, summary.chi2_start,
      summary.chi2_final, summary.iterations, summary.converged ? "" : " (not converged)", seconds);
  fmt::print("rejected edges {}\n", summary.rejected_edges.size());
  for (const std::uint32_t f : summary.rejected_edges)
    fmt::print("  {} {}\n", graph.ids[graph.factors[f].i], graph.ids[graph.factors[f].j]);
}

double secondsSince(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// Pose by pose, as a run would have seen the graph.
PoseGraph solvedOnline(const PoseGraph& graph, const OptimiserParams& params, Log& log) {
  IncrementalOptimiser optimiser(params);
  std::size_t solves = 0;
  double total_s = 0, worst_s = 0;
  PoseGraph grown = replayGraph(graph, [&](PoseGraph& so_far) {
    const auto begin = std::chrono::steady_clock::now();
    solves += optimiser.update(so_far);
    const double seconds = secondsSince(begin);
    total_s += seconds;
    worst_s = std::max(worst_s, seconds);
  });
  logInfo(log, "online: {} poses, {} solves, {:.3f} s in total, {:.2f} ms the worst update; chi2 {:.8g}",
          grown.poses.size(), solves, total_s, 1e3 * worst_s, graphChi2(grown));
  return grown;
}

int optimizeFile(const Options& options, const GlobalOptions& global) {
  Log log(verbosity(global));
  G2oFile file = readG2o(options.input);
  for (const std::string& warning : file.warnings) logWarn(log, "{}", warning);
  if (!file.poses_known && options.params.init == "file")
    throw usageError("{} has no vertices to start from; use --init auto, chordal or spanning", options.input);
  const auto begin = std::chrono::steady_clock::now();
  if (!file.poses_known) placeAlongSpanningTree(file.graph);
  const double chi2_initial = graphChi2(file.graph);
  if (options.incremental) file.graph = solvedOnline(file.graph, options.params, log);
  OptimiserSummary summary = optimise(file.graph, options.params);
  summary.chi2_initial = chi2_initial;
  const double seconds = secondsSince(begin);
  if (!summary.converged) logWarn(log, "stopped after {} iterations without converging", summary.iterations);
  if (!options.output.empty()) {
    writeFileAtomically(options.output, formatG2o(file.graph, file.graph.planar));
    logInfo(log, "wrote {}", options.output);
  }
  (options.json ? printJson : printTable)(file.graph, summary, seconds);
  return static_cast<int>(ExitCode::kDone);
}

}  // namespace

Verb optimizeVerb() {
  return {"optimize", "optimise a pose graph (g2o file)", [](CLI::App& app) {
            auto options = std::make_shared<Options>();
            app.add_option("input", options->input, "the graph: g2o, 3-D or 2-D")->required()->type_name("IN.g2o");
            app.add_option("-o,--output", options->output, "write the optimised graph here")->type_name("OUT.g2o");
            app.add_option("--robust", options->params.robust, "kernel on loop edges (others than i, i+1)")
                ->check(CLI::IsMember(robustChoices()))
                ->capture_default_str();
            app.add_option("--init", options->params.init, "start; auto = the best of the three")
                ->check(CLI::IsMember({"auto", "file", "chordal", "spanning"}))
                ->capture_default_str();
            app.add_flag("--incremental", options->incremental,
                         "add the poses one by one as a run would, then optimise from there");
            app.add_flag("--json", options->json, "one JSON object on stdout");
            return [options](const GlobalOptions& global) { return optimizeFile(*options, global); };
          }};
}

}  // namespace scslam::cli
