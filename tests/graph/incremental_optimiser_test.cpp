#include "scslam/graph/incremental_optimiser.h"

#include <numeric>

#include "graph/graph_fixtures.h"
#include "scslam/graph/factor_error.h"
#include "scslam/graph/g2o.h"
#include "scslam/graph/replay.h"
#include "support/support.h"

namespace scslam {
namespace {

OptimiserParams with(const std::string& robust) {
  OptimiserParams params;
  params.robust = robust;
  return params;
}

/// A walk of `laps` whose laps few loops join: what a run makes.
test::SquareWalk sparseWalk(bool planar = false, int side = 25, int laps = 4) {
  test::SquareWalk walk(side, laps, 0.02, 5, planar);
  std::size_t k = 0;
  std::erase_if(walk.graph.factors, [&](const Factor& f) { return f.kind == FactorKind::kLoop && k++ % 12 != 0; });
  return walk;
}

TEST(CondensedChain, ASegmentIsTheOptimumOfItsStepsGivenTheEnds) {
  for (const bool planar : {false, true}) {
    test::SquareWalk walk(4, 1, 0.05, 3, planar);
    std::mt19937 random(4);
    for (Factor& factor : walk.graph.factors)
      factor.information = planar ? Matrix6d(factor.information) : Matrix6d(400 * test::randomInformation(random));
    std::swap(walk.graph.factors[3].i, walk.graph.factors[3].j);  // a step that was measured backwards
    walk.graph.factors[3].T_i_j = walk.graph.factors[3].T_i_j.inverse();
    PoseGraph& graph = walk.graph;
    const auto last = static_cast<std::uint32_t>(graph.poses.size() - 1);
    detail::CondensedChain chain;
    std::vector<std::uint8_t> is_step;
    chain.takeSteps(graph, is_step);
    const auto& segments = chain.segmentsBetween({0, last}, planar);
    ASSERT_EQ(segments.size(), 1u);
    Vector6d bend = Vector6d::Zero();
    bend << 0.03, -0.02, 0, 0, 0, 0.01;
    if (!planar) bend += Vector6d::Constant(0.01);
    graph.poses[last] = retract(graph.poses[last], bend);
    graph.fixed = {0, last};
    segments[0].placeInner(graph.poses);
    const double condensed =
        segments[0].error(graph.poses).dot(segments[0].information * segments[0].error(graph.poses));
    const double placed = graphChi2(graph);
    OptimiserParams params;
    params.init = "file";
    params.relative_decrease = 1e-12;
    const double optimum = optimise(graph, params).chi2_final;
    EXPECT_GT(optimum, 0.01);
    EXPECT_NEAR(condensed, optimum, 0.01 * optimum) << planar;
    EXPECT_NEAR(placed, optimum, 0.01 * optimum) << planar;
  }
}

TEST(CondensedChain, StepsThatAreMissingCutIt) {
  test::SquareWalk walk(4, 1, 0);
  std::erase_if(walk.graph.factors, [](const Factor& f) { return f.j == 5; });
  detail::CondensedChain chain;
  std::vector<std::uint8_t> is_step;
  chain.takeSteps(walk.graph, is_step);
  EXPECT_FALSE(chain.joined(0));
  EXPECT_TRUE(chain.joined(4));
  EXPECT_FALSE(chain.joined(5));
  const auto& segments = chain.segmentsBetween({0, 2, 7, 9}, false);
  ASSERT_EQ(segments.size(), 2u);
  EXPECT_EQ(segments[1].begin, 7u);
}

TEST(Incremental, StaysAtTheOptimumOfWhatHasComeWithFewVariables) {
  for (const bool planar : {false, true}) {
    const test::SquareWalk walk = sparseWalk(planar);
    IncrementalOptimiser optimiser(with("none"));
    std::size_t loops = 0, solves = 0;
    const PoseGraph online = replayGraph(walk.graph, [&](PoseGraph& grown) {
      const std::size_t now = grown.factors.size() - (grown.poses.size() - 1);
      if (now == loops) return;
      loops = now, ++solves;
      const IncrementalSummary summary = optimiser.solve(grown);
      EXPECT_TRUE(summary.converged);
      EXPECT_FALSE(summary.full);
      EXPECT_LE(summary.variables, 2 * loops + grown.poses.size() / 64 + 2);
    });
    EXPECT_EQ(solves, loops);
    EXPECT_GT(loops, 5u);
    PoseGraph batch = online;
    const auto best = optimise(batch);
    EXPECT_NEAR(graphChi2(online), best.chi2_final, 0.02 * best.chi2_final) << planar;  // first order between keys
    for (std::size_t k = 0; k < batch.poses.size(); ++k)
      EXPECT_THAT(online.poses[k], test::IsNear(batch.poses[k], 0.02, 0.1)) << k;
    PoseGraph finished = online;
    OptimiserParams params;
    params.init = "file";
    EXPECT_NEAR(optimise(finished, params).chi2_final, best.chi2_final, 1e-6 * best.chi2_final) << planar;
  }
}

TEST(Incremental, SolvesOnlyWhereSomethingContradicts) {
  const test::SquareWalk walk = sparseWalk();
  IncrementalOptimiser optimiser(with("none"));
  std::size_t loops = 0, solves = 0;
  PoseGraph online = replayGraph(walk.graph, [&](PoseGraph& grown) {
    const std::size_t now = grown.factors.size() - (grown.poses.size() - 1);
    const bool solved = optimiser.update(grown);
    EXPECT_FALSE(solved && now == loops) << "odometry alone";
    loops = now, solves += solved;
  });
  EXPECT_GT(solves, 0u);
  Factor agreed = test::between(online.poses, 3, 150, FactorKind::kLoop);  // adds nothing to the cost
  online.factors.push_back(agreed);
  EXPECT_FALSE(optimiser.update(online));
  agreed.T_i_j.translation().x() += 50;
  online.factors.push_back(agreed);
  EXPECT_TRUE(optimiser.update(online));
}

TEST(Incremental, SolvesAllNodesWhenMostOfThemAreTouched) {
  test::SquareWalk walk(10, 3, 0.02);
  IncrementalOptimiser optimiser(with("none"));
  PoseGraph online = walk.graph;
  Factor fix;
  fix.kind = FactorKind::kPrior;
  for (std::uint32_t k = 0; k < online.poses.size(); k += 2) {
    fix.i = fix.j = k, fix.T_i_j = walk.truth[k];
    online.factors.push_back(fix);
  }
  PoseGraph batch = online;
  EXPECT_TRUE(optimiser.solve(online).full);
  optimise(batch);
  EXPECT_NEAR(graphChi2(online), graphChi2(batch), 1e-3 * graphChi2(batch));
}

TEST(Incremental, SolvesAllNodesWhenASegmentIsBentBeyondTheFirstOrder) {
  test::SquareWalk walk(5, 3, 0);
  std::erase_if(walk.graph.factors, [](const Factor& f) { return f.kind == FactorKind::kLoop; });
  PoseGraph graph = walk.graph;
  Factor loop = test::between(walk.truth, 1, 58, FactorKind::kLoop);
  loop.T_i_j = loop.T_i_j * poseFromYaw(0.5, {0, 1, 0});
  loop.information *= 1e6;
  graph.factors.push_back(loop);
  PoseGraph batch = graph;
  const IncrementalSummary summary = IncrementalOptimiser(with("none")).solve(graph);
  EXPECT_TRUE(summary.full);
  EXPECT_TRUE(summary.converged);
  const auto best = optimise(batch);
  EXPECT_NEAR(graphChi2(graph), best.chi2_final, 1e-3 * best.chi2_final);
}

TEST(Incremental, TakesAFalseLoopForWhatItIsAndForgetsOneThatIsTakenBack) {
  for (const auto* robust : {"cauchy", "dcs", "gnc"}) {
    const test::SquareWalk walk = sparseWalk();
    PoseGraph graph = walk.graph;
    Factor wrong = test::between(walk.truth, 20, 250, FactorKind::kLoop);
    wrong.T_i_j = wrong.T_i_j * poseFromYaw(1, {4, 4, 0});
    wrong.information *= 1e3;
    IncrementalOptimiser optimiser(with(robust));
    PoseGraph without = graph;
    optimiser.solve(without);
    graph.factors.push_back(wrong);
    const auto number = static_cast<std::uint32_t>(graph.factors.size() - 1);
    EXPECT_EQ(optimiser.solve(graph).rejected_edges, std::vector<std::uint32_t>{number}) << robust;
    graph.factors.pop_back();
    EXPECT_TRUE(optimiser.solve(graph).rejected_edges.empty());
    for (std::size_t k = 0; k < graph.poses.size(); ++k)
      EXPECT_THAT(graph.poses[k], test::IsNear(without.poses[k], 0.05, 0.2)) << robust << ' ' << k;
  }
}

TEST(Incremental, DependsOnTheGraphAloneNotOnTheCallsBefore) {
  test::SquareWalk walk = sparseWalk();
  const Factor last = walk.graph.factors.back();
  walk.graph.factors.pop_back();
  PoseGraph before = walk.graph;
  IncrementalOptimiser old(with("dcs"));
  old.solve(before);
  before.factors.push_back(last);
  PoseGraph fresh = before;
  old.solve(before);
  IncrementalOptimiser(with("dcs")).solve(fresh);
  EXPECT_EQ(formatG2o(before), formatG2o(fresh));
}

TEST(Incremental, CarriesThePosesBehindTheLastLoopAlong) {
  test::SquareWalk walk = sparseWalk();
  PoseGraph& graph = walk.graph;
  std::uint32_t last = 0;
  for (const Factor& f : graph.factors)
    if (f.kind == FactorKind::kLoop) last = std::max({last, f.i, f.j});
  last = std::max(last, static_cast<std::uint32_t>(graph.poses.size() - 1) / 64 * 64);
  ASSERT_LT(last + 2, graph.poses.size());
  IncrementalOptimiser(with("none")).solve(graph);
  for (std::size_t k = last + 1; k < graph.poses.size(); ++k)
    EXPECT_THAT(Pose(graph.poses[k - 1].inverse() * graph.poses[k]),
                test::IsNear(graph.factors[k - 1].T_i_j, 1e-9, 1e-7));
}

TEST(Incremental, SurvivesGraphsThatNothingDetermines) {
  IncrementalOptimiser optimiser(with("dcs"));
  PoseGraph graph;
  EXPECT_EQ(optimiser.solve(graph).variables, 0u);
  graph.poses.resize(4, Pose::Identity());
  optimiser.solve(graph);
  Factor loop = test::between(graph.poses, 0, 3, FactorKind::kLoop);
  loop.T_i_j = poseFromYaw(0.1, {1, 0, 0});
  graph.factors.push_back(loop);
  optimiser.solve(graph);
  EXPECT_THAT(graph.poses[3], test::IsNear(loop.T_i_j, 1e-3, 0.01));
  loop.information.setZero();
  loop.j = 2;
  graph.factors.push_back(loop);
  optimiser.solve(graph);
  for (const Pose& pose : graph.poses) EXPECT_TRUE(isRigid(pose));
}

class IncrementalOnRealGraphs : public ::testing::TestWithParam<const char*> {};

TEST_P(IncrementalOnRealGraphs, TheBatchAfterItIsTheBatchWithoutIt) {
  SCSLAM_NEEDS_DATA(file, std::string("g2o/") + GetParam());
  G2oFile read = readG2o(file);
  if (!read.poses_known) placeAlongSpanningTree(read.graph);
  IncrementalOptimiser optimiser(with("none"));
  PoseGraph online = replayGraph(read.graph, [&](PoseGraph& grown) { optimiser.update(grown); });
  const double best = optimise(read.graph).chi2_final;
  EXPECT_NEAR(graphChi2(online), best, 0.02 * best);
  OptimiserParams params;
  params.init = "file";
  EXPECT_NEAR(optimise(online, params).chi2_final, best, 1e-6 * best);
}
INSTANTIATE_TEST_SUITE_P(All, IncrementalOnRealGraphs, ::testing::Values("kitti_05.g2o", "parking-garage.g2o"));

}  // namespace
}  // namespace scslam
