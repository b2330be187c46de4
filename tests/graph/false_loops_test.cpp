#include "scslam/graph/false_loops.h"

#include "graph/graph_fixtures.h"
#include "support/support.h"

namespace scslam {
namespace {

PoseGraph walked() {
  test::SquareWalk walk(20, 3, 0.02);
  walk.graph.poses = walk.truth;
  return walk.graph;
}

TEST(FalseLoops, ClaimWhatTrueLoopsMeasureBetweenPlacesThatAreFarApart) {
  PoseGraph graph = walked();
  const std::size_t before = graph.factors.size();
  const auto added = addFalseLoops(graph, {30, 5, 1});
  ASSERT_EQ(added.size(), 30u);
  ASSERT_EQ(graph.factors.size(), before + 30);
  for (const std::uint32_t f : added) {
    const Factor& loop = graph.factors[f];
    EXPECT_GE(f, before);
    EXPECT_EQ(loop.kind, FactorKind::kLoop);
    EXPECT_GE(std::max(loop.i, loop.j) - std::min(loop.i, loop.j), graph.poses.size() / 10);
    const Pose error = loop.T_i_j.inverse() * (graph.poses[loop.i].inverse() * graph.poses[loop.j]);
    EXPECT_TRUE(error.translation().norm() >= 0.9 || rotationAngle(error) >= 20 * M_PI / 180);
    EXPECT_LT(loop.T_i_j.translation().norm(), 0.2) << "the loops of this walk measure the same place";
  }
}

TEST(FalseLoops, OfOneGroupAgreeWithEachOther) {
  PoseGraph graph = walked();
  const auto added = addFalseLoops(graph, {12, 2, 4});
  ASSERT_EQ(added.size(), 12u);
  for (std::size_t k = 0; k < added.size(); ++k) {
    if (k % 4 == 0) continue;
    const Factor &first = graph.factors[added[k - k % 4]], &other = graph.factors[added[k]];
    const Pose around = first.T_i_j * (graph.poses[first.j].inverse() * graph.poses[other.j]) * other.T_i_j.inverse() *
                        (graph.poses[other.i].inverse() * graph.poses[first.i]);
    EXPECT_THAT(around, test::IsNear(Pose::Identity(), 1e-9, 1e-7));
  }
}

TEST(FalseLoops, DependOnTheSeedAlone) {
  PoseGraph a = walked(), b = walked(), c = walked();
  addFalseLoops(a, {10, 1, 1});
  addFalseLoops(b, {10, 1, 1});
  addFalseLoops(c, {10, 2, 1});
  const auto ends = [](const PoseGraph& graph) { return std::pair{graph.factors.back().i, graph.factors.back().j}; };
  EXPECT_EQ(ends(a), ends(b));
  EXPECT_NE(ends(a), ends(c));
}

TEST(FalseLoops, AreNoneInAGraphThatIsTooSmall) {
  test::SquareWalk walk(2, 2, 0);
  EXPECT_TRUE(addFalseLoops(walk.graph, {5, 1, 1}).empty());
}

}  // namespace
}  // namespace scslam
