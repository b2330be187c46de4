// False loops in public graphs: every one out, the true ones in, the map where it is without them.
#include <set>

#include "bench/made_graphs.h"
#include "scslam/graph/factor_error.h"
#include "scslam/graph/false_loops.h"
#include "scslam/graph/g2o.h"
#include "scslam/graph/optimiser.h"
#include "support/support.h"

namespace scslam {
namespace {

/// A graph at its optimum, with the poses its file starts from.
struct CleanGraph {
  PoseGraph graph;
  std::vector<Pose> start;
  double chi2;

  explicit CleanGraph(PoseGraph from) : graph(std::move(from)), start(graph.poses) {
    chi2 = optimise(graph).chi2_final;
  }
};

/// What is asked of `--robust gnc` whatever the seed.
void expectSorted(const CleanGraph& clean, const FalseLoopOptions& options, const std::string& robust) {
  PoseGraph graph = clean.graph;
  const auto added = addFalseLoops(graph, options);
  ASSERT_EQ(added.size(), options.count);
  graph.poses = clean.start;
  OptimiserParams params;
  params.robust = robust;
  const auto summary = optimise(graph, params);
  const std::set<std::uint32_t> rejected(summary.rejected_edges.begin(), summary.rejected_edges.end());
  for (const std::uint32_t f : added) EXPECT_TRUE(rejected.contains(f)) << "false loop kept: " << f;
  const auto loops = std::count_if(clean.graph.factors.begin(), clean.graph.factors.end(),
                                   [](const Factor& factor) { return factor.kind == FactorKind::kLoop; });
  EXPECT_LE(static_cast<double>(rejected.size() - added.size()), 0.01 * static_cast<double>(loops));
  graph.factors.resize(clean.graph.factors.size());
  EXPECT_LT(graphChi2(graph), 1.01 * clean.chi2);
}

class FalseLoopsInPublicGraphs : public ::testing::TestWithParam<const char*> {};

TEST_P(FalseLoopsInPublicGraphs, AreAllRejectedAndNoneOfTheTrueOnes) {
  SCSLAM_NEEDS_DATA(file, std::string("g2o/") + GetParam());
  const CleanGraph clean(readG2o(file).graph);
  std::uint64_t seed = 100;
  for (const std::size_t count : {10, 200}) {
    SCOPED_TRACE(count);
    expectSorted(clean, {count, ++seed, 1}, "gnc");
  }
}
INSTANTIATE_TEST_SUITE_P(All, FalseLoopsInPublicGraphs, ::testing::Values("sphere2500.g2o", "parking-garage.g2o"));

// One of its loops is the first after 2 km: far beyond the gate until the poses follow it.
TEST(FalseLoopsOnARoad, AreAllRejectedAndTheLoneTrueOneAfterALongDriftIsKept) {
  const CleanGraph clean(bench::roadGraph().graph);
  for (const std::size_t group : {1, 10})
    for (const std::size_t count : {0, 200}) {
      SCOPED_TRACE(::testing::Message() << count << " in groups of " << group);
      expectSorted(clean, {count, count + 1, group}, "gnc");
    }
}

}  // namespace
}  // namespace scslam
