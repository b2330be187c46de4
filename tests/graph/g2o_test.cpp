#include "scslam/graph/g2o.h"

#include <fstream>

#include "graph/graph_fixtures.h"
#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/graph/factor_error.h"
#include "support/support.h"

namespace scslam {
namespace {

using ::testing::HasSubstr;

std::filesystem::path fileOf(const std::string& text) {
  const auto file = test::freshFolder() / "graph.g2o";
  std::ofstream(file) << text;
  return file;
}

std::string errorOf(const std::string& text) {
  try {
    readG2o(fileOf(text));
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    return error.what();
  }
  return "no error";
}

const std::string kVertices = "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\n";

TEST(G2o, WritesWhatItReadsBackToTheSameNumbers) {
  std::mt19937 random(3);
  PoseGraph graph;
  graph.ids = {-4, 7, 6989586621679009793};
  for (int k = 0; k < 3; ++k) graph.poses.push_back(test::randomPose(random));
  for (const auto& [i, j] : {std::pair{0u, 1u}, {2u, 1u}, {0u, 2u}}) {
    graph.factors.push_back(test::between(graph.poses, i, j, FactorKind::kOdometry, test::randomVector(random, 1, 1)));
    graph.factors.back().information = test::randomInformation(random);
  }
  graph.fixed = {1};
  const PoseGraph read = readG2o(fileOf(formatG2o(graph))).graph;
  EXPECT_EQ(read.ids, graph.ids);
  EXPECT_EQ(read.fixed, graph.fixed);
  ASSERT_EQ(read.factors.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_THAT(read.poses[k], test::IsNear(graph.poses[k], 0, 1e-12));
    EXPECT_THAT(read.factors[k].T_i_j, test::IsNear(graph.factors[k].T_i_j, 1e-14, 1e-12));
    EXPECT_EQ(read.factors[k].i, graph.factors[k].i);
    EXPECT_EQ(read.factors[k].information,
              graph.factors[k].information.selfadjointView<Eigen::Upper>().toDenseMatrix());
  }
  EXPECT_EQ(read.factors[1].kind, FactorKind::kOdometry);
  EXPECT_EQ(read.factors[2].kind, FactorKind::kLoop);
}

TEST(G2o, KeepsPlanarGraphsPlanar) {
  const auto read =
      readG2o(fileOf("VERTEX_SE2 3 0 0 0\nVERTEX_SE2 5 1 2 0.5\n"
                     "EDGE_SE2 3 5 1.5 2 0.4 2 0.5 0.25 3 0.125 7\n"));
  EXPECT_TRUE(read.graph.planar);
  // r = R(0.4)^T ((1, 2) - (1.5, 2)) and yaw 0.1
  const double x = -0.5 * std::cos(0.4), y = 0.5 * std::sin(0.4), a = 0.1;
  const double expected = 2 * x * x + 3 * y * y + 7 * a * a + 2 * (0.5 * x * y + 0.25 * x * a + 0.125 * y * a);
  EXPECT_NEAR(graphChi2(read.graph), expected, 1e-12);
  const std::string text = formatG2o(read.graph, true);
  EXPECT_THAT(text, HasSubstr("EDGE_SE2 3 5 1.5 2 0.4"));
  EXPECT_NEAR(graphChi2(readG2o(fileOf(text)).graph), expected, 1e-12);
}

TEST(G2o, TakesEdgesWithoutVerticesAndWithoutInformation) {
  const auto read = readG2o(fileOf("# comment\r\n\nEDGE_SE3:QUAT 9 4 1 0 0 0 0 0 1\r\n"));
  EXPECT_FALSE(read.poses_known);
  EXPECT_EQ(read.graph.ids, (std::vector<std::int64_t>{4, 9}));
  EXPECT_EQ(read.graph.factors[0].i, 1u);
  EXPECT_EQ(read.graph.factors[0].information, Matrix6d::Identity());
}

TEST(G2o, NamesEachUnknownTagOnce) {
  const auto read = readG2o(fileOf(kVertices + "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1\nVERTEX_XY 5 1 1\nVERTEX_XY 6 1 1\n"));
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_THAT(read.warnings[0], HasSubstr(":4: lines 'VERTEX_XY'"));
}

TEST(G2o, SaysWhichPartsFloat) {
  const auto read = readG2o(fileOf(kVertices));
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_THAT(read.warnings[0], HasSubstr("2 unconnected parts"));
}

struct BadLine {
  const char* line;
  const char* message;
};
class G2oBadLine : public ::testing::TestWithParam<BadLine> {};

TEST_P(G2oBadLine, IsRefusedWithItsNumber) {
  const std::string error = errorOf(kVertices + GetParam().line + "\n");
  EXPECT_THAT(error, HasSubstr("graph.g2o:3: "));
  EXPECT_THAT(error, HasSubstr(GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    All, G2oBadLine,
    ::testing::Values(BadLine{"EDGE_SE3:QUAT 0 1 1 0 0 0 0 0", "the line ends where a number"},
                      BadLine{"EDGE_SE3:QUAT 0", "the line ends where a vertex"},
                      BadLine{"EDGE_SE3:QUAT 0 1.5 1 0 0 0 0 0 1", "'1.5' is no vertex number"},
                      BadLine{"EDGE_SE3:QUAT 0 99999999999999999999 1 0 0 0 0 0 1", "is no vertex number"},
                      BadLine{"EDGE_SE3:QUAT 0 2 1 0 0 0 0 0 1", "vertex 2 is not in the file"},
                      BadLine{"EDGE_SE3:QUAT 1 1 1 0 0 0 0 0 1", "to itself"},
                      BadLine{"EDGE_SE3:QUAT 0 1 nan 0 0 0 0 0 1", "'nan' is not a finite number"},
                      BadLine{"EDGE_SE3:QUAT 0 1 1e999 0 0 0 0 0 1", "'1e999' is not a finite number"},
                      BadLine{"EDGE_SE3:QUAT 0 1 1,0 0 0 0 0 0 1", "'1,0' is not a number"},
                      BadLine{"EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 2", "length 2, not 1"},
                      BadLine{"EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1 1 0 0 0 0 0 1", "the line ends"},
                      BadLine{"EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1 -1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1",
                              "negative number"},
                      BadLine{"VERTEX_SE3:QUAT 1 1 0 0 0 0 0 1", "vertex 1 was already given in line 2"},
                      BadLine{"VERTEX_SE3:QUAT 2 1 0 0 0 0 0 1 5", "'5' follows"},
                      BadLine{"FIX 7", "vertex 7 is not in the file"}));

TEST(G2o, ReplacesIndefiniteInformationByTheNearestThatIsNot) {
  const std::string indefinite = "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1 1 2 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n";
  const auto read = readG2o(fileOf(kVertices + indefinite + indefinite));
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_THAT(read.warnings[0], HasSubstr("graph.g2o:3: "));
  EXPECT_THAT(read.warnings[0], HasSubstr("first of 2"));
  Matrix6d expected = Matrix6d::Identity();  // eigenvalues 3 and -1 of (1 2; 2 1): 3 (1 1)^T (1 1) / 2
  expected.topLeftCorner<2, 2>().setConstant(1.5);
  for (const Factor& factor : read.graph.factors) EXPECT_LT((factor.information - expected).norm(), 1e-12);
}

TEST(G2o, RefusesFilesThatAreNone) {
  EXPECT_THAT(errorOf("hello\n"), HasSubstr("is it a g2o file?"));
  EXPECT_THAT(errorOf(kVertices + "VERTEX_SE2 3 0 0 0\n"), HasSubstr("mixes SE2 and SE3"));
  EXPECT_THROW(readG2o("/nonexistent/a.g2o"), Error);
}

TEST(G2o, ReadsTheRealGraphs) {
  SCSLAM_NEEDS_DATA(folder, "g2o");
  const auto sphere = readG2o(folder / "sphere2500.g2o");
  EXPECT_EQ(sphere.graph.poses.size(), 2500u);
  EXPECT_EQ(sphere.graph.factors.size(), 4949u);
  EXPECT_TRUE(sphere.warnings.empty());
  const auto kitti = readG2o(folder / "kitti_05.g2o");
  EXPECT_TRUE(kitti.graph.planar);
  EXPECT_FALSE(kitti.poses_known);
  EXPECT_EQ(kitti.graph.factors.size(), 2826u);
  const auto loops = readG2o(folder / "kitti_05_loop_closure.g2o");
  ASSERT_EQ(loops.warnings.size(), 1u);
  EXPECT_THAT(loops.warnings[0], HasSubstr("2724 unconnected parts"));
}

}  // namespace
}  // namespace scslam
