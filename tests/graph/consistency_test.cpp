#include "scslam/graph/consistency.h"

#include <algorithm>
#include <bit>

#include "graph/graph_fixtures.h"
#include "support/support.h"

namespace scslam {
namespace {

using Nodes = std::vector<std::uint32_t>;

BitGraph graphOf(std::size_t n, const std::vector<std::pair<std::uint32_t, std::uint32_t>>& edges) {
  BitGraph graph;
  for (std::uint32_t v = 0; v < n; ++v) {
    Nodes before;
    for (const auto& [a, b] : edges)
      if (std::max(a, b) == v) before.push_back(std::min(a, b));
    graph.add(before);
  }
  return graph;
}
Nodes all(std::size_t n) {
  Nodes nodes(n);
  for (std::uint32_t v = 0; v < n; ++v) nodes[v] = v;
  return nodes;
}

TEST(MaxClique, FindsTheLargestOfSmallKnownGraphs) {
  EXPECT_EQ(maxClique(graphOf(5, {{0, 1}, {1, 2}, {0, 2}, {2, 3}, {3, 4}}), all(5), 0).nodes, (Nodes{0, 1, 2}));
  EXPECT_EQ(maxClique(graphOf(4, {}), all(4), 0).nodes.size(), 1u);
  EXPECT_TRUE(maxClique(graphOf(4, {}), all(4), 1).nodes.empty()) << "none is larger than one";
  EXPECT_TRUE(maxClique(BitGraph(), {}, 0).nodes.empty());
}

TEST(MaxClique, AgreesWithTryingAllSubsets) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 60; ++trial) {
    constexpr std::uint32_t n = 13;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (std::uint32_t a = 0; a < n; ++a)
      for (std::uint32_t b = a + 1; b < n; ++b)
        if (random() % 100 < 30u + static_cast<unsigned>(trial)) edges.emplace_back(a, b);
    const BitGraph graph = graphOf(n, edges);
    std::size_t largest = 0;
    for (unsigned subset = 1; subset < 1u << n; ++subset) {
      bool clique = true;
      for (std::uint32_t a = 0; a < n && clique; ++a)
        for (std::uint32_t b = a + 1; b < n && clique; ++b)
          if ((subset >> a & 1) != 0 && (subset >> b & 1) != 0) clique = graph.joined(a, b);
      if (clique) largest = std::max(largest, static_cast<std::size_t>(std::popcount(subset)));
    }
    const CliqueResult found = maxClique(graph, all(n), 0);
    EXPECT_TRUE(found.exact);
    ASSERT_EQ(found.nodes.size(), largest);
    for (const auto a : found.nodes)
      for (const auto b : found.nodes) EXPECT_TRUE(a == b || graph.joined(a, b));
  }
}

TEST(MaxClique, EndsWithinItsBudgetOnALargeDenseGraph) {
  std::mt19937 random(4);
  BitGraph graph;
  for (std::uint32_t v = 0; v < 700; ++v) {
    Nodes before;
    for (std::uint32_t u = 0; u < v; ++u)
      if (random() % 10 < 7) before.push_back(u);
    graph.add(before);
  }
  const CliqueResult found = maxClique(graph, all(700), 0, 2000);
  EXPECT_FALSE(found.exact);
  EXPECT_GT(found.nodes.size(), 15u);
  EXPECT_EQ(found.nodes, maxClique(graph, all(700), 0, 2000).nodes);
}

struct LoopsOfAWalk {
  test::SquareWalk walk{25, 4, 0.01};
  LoopConsistency loops{ConsistencyParams{}};
  LoopsOfAWalk() {
    double travelled = 0;
    for (std::size_t k = 0; k < walk.graph.poses.size(); ++k)
      loops.addNode(walk.graph.poses[k], travelled++,
                    k == 0 ? Matrix6d::Zero() : Matrix6d(1e-4 * Matrix6d::Identity()));
  }
  Factor trueLoop(std::uint32_t i, std::uint32_t j) const {
    Factor loop = test::between(walk.truth, i, j, FactorKind::kLoop);
    loop.information = 1e4 * Matrix6d::Identity();
    return loop;
  }
  Factor falseLoop(std::uint32_t i, std::uint32_t j) const {
    Factor loop = trueLoop(i, j);
    loop.T_i_j = poseFromYaw(0.3, {0.5, -1, 0});  // "the same place"
    return loop;
  }
};

TEST(LoopConsistency, TrueLoopsAgreeInBothDirectionsAndOrders) {
  LoopsOfAWalk it;
  for (std::uint32_t k = 100; k < 400; k += 10) {
    Factor loop = it.trueLoop(k - 100, k);
    if (k % 20 == 0) std::swap(loop.i, loop.j), loop.T_i_j = Pose(loop.T_i_j.inverse());
    it.loops.addLoop(loop);
  }
  EXPECT_EQ(std::count(it.loops.believed().begin(), it.loops.believed().end(), 1), 30);
  EXPECT_NEAR(it.loops.disagreement(3, 8), it.loops.disagreement(8, 3), 0.2 * it.loops.disagreement(3, 8) + 0.05);
}

TEST(LoopConsistency, FalseLoopsAmongTrueOnesAreNotBelieved) {
  LoopsOfAWalk it;
  std::vector<std::uint8_t> truth;
  for (std::uint32_t k = 100; k < 400; k += 10) {
    it.loops.addLoop(it.trueLoop(k - 100, k));
    truth.push_back(1);
    it.loops.addLoop(it.falseLoop((k + 40 + (7 * k) % 23) % 100, k));
    truth.push_back(0);
  }
  EXPECT_EQ(it.loops.believed(), truth);
}

TEST(LoopConsistency, AFalseLoopThatCameFirstIsTakenBack) {
  LoopsOfAWalk it;
  it.loops.addLoop(it.falseLoop(0, 50));
  EXPECT_EQ(it.loops.believed(), std::vector<std::uint8_t>{1}) << "nothing speaks against it yet";
  it.loops.addLoop(it.trueLoop(2, 102));
  it.loops.addLoop(it.trueLoop(5, 105));
  EXPECT_EQ(it.loops.believed(), (std::vector<std::uint8_t>{0, 1, 1}));
}

TEST(LoopConsistency, WhereOdometryLostTrackSomeMustAgreeBeforeAnyIsBelieved) {
  const test::SquareWalk walk{25, 4, 0.01};
  LoopConsistency loops{ConsistencyParams{}};
  const auto n = static_cast<std::uint32_t>(walk.graph.poses.size());
  for (std::uint32_t k = 0; k < n; ++k)
    loops.addNode(walk.graph.poses[k], k, (k == 60 ? 1e3 : 1e-4) * Matrix6d::Identity());
  const auto loop = [&](std::uint32_t i, std::uint32_t j) {
    Factor factor = test::between(walk.truth, i, j, FactorKind::kLoop);
    factor.information = 1e4 * Matrix6d::Identity();
    return factor;
  };
  loops.addLoop(loop(0, 100));
  loops.addLoop(loop(2, 40));  // on one side: odometry vouches for it
  loops.addLoop(loop(10, 110));
  EXPECT_EQ(loops.believed(), (std::vector<std::uint8_t>{0, 1, 0}));
  EXPECT_TRUE(loops.waits(0));
  EXPECT_FALSE(loops.waits(1));
  loops.addLoop(loop(20, 120));
  EXPECT_EQ(loops.believed(), (std::vector<std::uint8_t>{1, 1, 1, 1}));
}

TEST(LoopConsistency, ADirectionTheLoopDoesNotFixCannotContradict) {
  LoopsOfAWalk it;
  it.loops.addLoop(it.trueLoop(0, 100));
  Factor corridor = it.trueLoop(20, 120);
  corridor.T_i_j = retract(corridor.T_i_j, (Vector6d() << 4, 0, 0, 0, 0, 0).finished());
  it.loops.addLoop(corridor);
  EXPECT_EQ(it.loops.believed()[1], 0);
  corridor.information.row(0).setZero();
  corridor.information.col(0).setZero();
  it.loops.addLoop(corridor);
  EXPECT_EQ(it.loops.believed()[2], 1);
}

}  // namespace
}  // namespace scslam
