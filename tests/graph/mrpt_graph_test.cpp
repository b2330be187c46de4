#include "scslam/graph/mrpt_graph.h"

#include "graph/graph_fixtures.h"
#include "scslam/core/error.h"
#include "support/support.h"

namespace scslam {
namespace {

TEST(MrptGraph, KeepsPosesEdgesAndInformationBothWays) {
  std::mt19937 random(21);
  PoseGraph graph;
  graph.ids = {3, 5, 9};
  for (int k = 0; k < 3; ++k) graph.poses.push_back(retract(Pose::Identity(), test::randomVector(random, 5, 0.8)));
  for (const auto& [i, j] : {std::pair{0u, 1u}, {0u, 2u}, {2u, 1u}}) {
    Factor factor;
    factor.i = i;
    factor.j = j;
    factor.kind = i == 0 && j == 2 ? FactorKind::kLoop : FactorKind::kOdometry;
    factor.T_i_j = retract(Pose::Identity(), test::randomVector(random, 2, 0.6));
    factor.information = test::randomInformation(random);
    graph.factors.push_back(factor);
  }
  const auto network = toMrpt(graph);
  EXPECT_EQ(network.root, 3u);
  EXPECT_EQ(network.edgeCount(), 3u);
  EXPECT_NEAR(network.nodes.at(5).x(), graph.poses[1].translation().x(), 1e-15);
  const PoseGraph back = fromMrpt(network);
  EXPECT_EQ(back.ids, graph.ids);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_THAT(back.poses[k], test::IsNear(graph.poses[k], 1e-12, 1e-9));
    EXPECT_EQ(back.factors[k].i, graph.factors[k].i);
    EXPECT_EQ(back.factors[k].kind, graph.factors[k].kind);
    EXPECT_THAT(back.factors[k].T_i_j, test::IsNear(graph.factors[k].T_i_j, 1e-12, 1e-9));
    EXPECT_LT((back.factors[k].information - graph.factors[k].information).norm(), 1e-8);
  }
}

TEST(MrptGraph, RefusesNegativeIds) {
  PoseGraph graph;
  graph.ids = {-1};
  graph.poses = {Pose::Identity()};
  EXPECT_THROW(toMrpt(graph), Error);
}

}  // namespace
}  // namespace scslam
