// The pose graph: graph_bench [GRAPH.g2o …], after two graphs made here (a road, a torus).
//
// batch:   ours = start (the best of file, spanning tree, chordal) + optimisation, against Ceres as we call it from the
//          same start and plain Ceres (plain_ceres.h) from the file's poses, in the same run; the best of several.
//          "of optimum" is the cost relative to the lowest that any of them found, from the truth too where it is
//          known.
// online:  pose by pose as a run would see them, an update after each.
// robust:  --robust gnc with false loops added, alone and in groups of ten that agree with each other.
#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <set>

#include "made_graphs.h"
#include "plain_ceres.h"
#include "scslam/core/error.h"
#include "scslam/graph/false_loops.h"
#include "scslam/graph/g2o.h"
#include "scslam/graph/incremental_optimiser.h"
#include "scslam/graph/optimiser.h"
#include "scslam/graph/replay.h"

namespace scslam::bench {
namespace {

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

MadeGraph fromFile(const std::string& path) {
  G2oFile file = readG2o(path);
  if (!file.poses_known) placeAlongSpanningTree(file.graph);
  return {std::filesystem::path(path).stem().string(), std::move(file.graph), {}};
}

OptimiserParams with(const std::string& robust, const std::string& solver = "auto") {
  OptimiserParams params;
  params.robust = robust;
  params.solver = solver;
  return params;
}

struct Timed {
  double best_ms = 1e300, chi2 = 0;
};

/// `solve` may change the copy of the graph that it gets. @return the best of up to five runs in about five seconds
template <class Solve>
Timed timed(const PoseGraph& graph, Solve solve) {
  constexpr double kBudget_ms = 5000;
  Timed result;
  double spent_ms = 0;
  for (int k = 0; k < 5 && spent_ms < kBudget_ms; ++k) {
    PoseGraph copy = graph;
    const auto begin = Clock::now();
    result.chi2 = solve(copy);
    const double elapsed_ms = millisecondsSince(begin);
    result.best_ms = std::min(result.best_ms, elapsed_ms);
    spent_ms += elapsed_ms;
  }
  return result;
}

double optimumFromTruth(const MadeGraph& made) {
  if (made.truth.empty()) return 1e300;
  PoseGraph graph = made.graph;
  graph.poses = made.truth;
  OptimiserParams params;
  params.init = "file";
  return optimise(graph, params).chi2_final;
}

void printBatch(const MadeGraph& made) {
  OptimiserSummary summary;
  const Timed ours = timed(made.graph, [&](PoseGraph& graph) {
    summary = optimise(graph);
    return summary.chi2_final;
  });
  const Timed tuned =
      timed(made.graph, [](PoseGraph& graph) { return optimise(graph, with("none", "ceres")).chi2_final; });
  const Timed plain = timed(made.graph, [](PoseGraph& graph) { return plainCeres(graph); });
  const double optimum = std::min({ours.chi2, tuned.chi2, plain.chi2, optimumFromTruth(made)});
  fmt::print("{:<16} {:>6} {:>6} {:>14.8g}  {:<8} {:>3} ", made.name, made.graph.poses.size(),
             made.graph.factors.size(), optimum, summary.start, summary.iterations);
  for (const Timed& result : {ours, tuned, plain})
    fmt::print(" {:>10.1f} ms {:>8.1e}", result.best_ms, result.chi2 / optimum - 1);
  fmt::print(" {:>8.3f}\n", ours.best_ms / plain.best_ms);
}

double rmse(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += (a[k].translation() - b[k].translation()).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

void printOnline(const MadeGraph& made) {
  IncrementalOptimiser optimiser(with("none"));
  std::vector<double> updates_ms;
  std::size_t solves = 0;
  const PoseGraph online = replayGraph(made.graph, [&](PoseGraph& grown) {
    const auto begin = Clock::now();
    solves += optimiser.update(grown);
    updates_ms.push_back(millisecondsSince(begin));
  });
  PoseGraph batch = online;
  const double optimum = optimise(batch).chi2_final;
  double total_ms = 0;
  for (const double ms : updates_ms) total_ms += ms;
  std::sort(updates_ms.begin(), updates_ms.end());
  const auto quantile = [&](double q) { return updates_ms[static_cast<std::size_t>(q * (updates_ms.size() - 1))]; };
  fmt::print("{:<16} {:>6} {:>8.3f} s {:>8.3f} {:>8.3f} {:>8.3f} {:>8.3f} ms {:>9.1e} {:>9.1e} m\n", made.name, solves,
             total_ms / 1e3, quantile(0.5), quantile(0.95), quantile(0.99), updates_ms.back(),
             graphChi2(online) / optimum - 1, rmse(online.poses, batch.poses));
}

std::size_t loopsIn(const PoseGraph& graph) {
  return static_cast<std::size_t>(std::count_if(graph.factors.begin(), graph.factors.end(),
                                                [](const Factor& factor) { return factor.kind == FactorKind::kLoop; }));
}

void printRobust(const MadeGraph& made) {
  PoseGraph clean = made.graph;
  const double clean_chi2 = optimise(clean).chi2_final;
  for (const std::size_t group : {1, 10})
    for (const std::size_t count : {10, 50, 100, 200}) {
      PoseGraph graph = clean;
      const auto added = addFalseLoops(graph, {count, count, group});
      graph.poses = made.graph.poses;
      const auto begin = Clock::now();
      const OptimiserSummary summary = optimise(graph, with("gnc"));
      const double elapsed_ms = millisecondsSince(begin);
      const std::set<std::uint32_t> rejected(summary.rejected_edges.begin(), summary.rejected_edges.end());
      const auto caught = static_cast<std::size_t>(
          std::count_if(added.begin(), added.end(), [&](std::uint32_t f) { return rejected.contains(f); }));
      graph.factors.resize(clean.factors.size());
      fmt::print("{:<16} {:>5} {:>5} {:>9} {:>6} of {:<6} {:>9.1e} {:>9.1e} m {:>8.1f} ms\n", made.name, added.size(),
                 group, caught, rejected.size() - caught, loopsIn(clean), graphChi2(graph) / clean_chi2 - 1,
                 rmse(graph.poses, clean.poses), elapsed_ms);
    }
}

void printTables(const std::vector<MadeGraph>& graphs) {
  fmt::print(
      "batch             poses  edges        optimum  start     it        ours, of optimum     Ceres, our start"
      "          plain Ceres      ours/plain\n");
  for (const MadeGraph& made : graphs) printBatch(made);
  fmt::print("\nonline           solves      total   median      95 %     99 %    worst    of optimum   to batch\n");
  for (const MadeGraph& made : graphs) printOnline(made);
  fmt::print("\nrobust           false group  rejected   true rejected  of clean   to clean         time\n");
  for (const MadeGraph& made : graphs) printRobust(made);
}

}  // namespace
}  // namespace scslam::bench

int main(int argc, char** argv) {
  try {
    std::vector<scslam::bench::MadeGraph> graphs = {scslam::bench::roadGraph(), scslam::bench::torusGraph()};
    for (int k = 1; k < argc; ++k) graphs.push_back(scslam::bench::fromFile(argv[k]));
    scslam::bench::printTables(graphs);
  } catch (const scslam::Error& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return static_cast<int>(error.code());
  }
  return 0;
}
