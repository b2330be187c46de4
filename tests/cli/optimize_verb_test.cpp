// scslam optimize, as a user runs it.
#include <fstream>
#include <nlohmann/json.hpp>

#include "graph/graph_fixtures.h"
#include "scslam/core/file.h"
#include "scslam/graph/g2o.h"
#include "support/support.h"

namespace scslam {
namespace {

using ::testing::HasSubstr;

TEST(OptimizeVerb, PrintsOneJsonObjectAndWritesTheGraph) {
  const auto folder = test::freshFolder();
  test::SquareWalk walk(5, 2, 0.05);
  writeFileAtomically(folder / "in.g2o", formatG2o(walk.graph));
  const auto run =
      test::runScslam("optimize " + (folder / "in.g2o").string() + " -o " + (folder / "out.g2o").string() + " --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  std::vector<std::string> keys;
  for (const auto& item : json.items()) keys.push_back(item.key());
  EXPECT_THAT(keys, ::testing::UnorderedElementsAre("poses", "edges", "chi2_initial", "chi2_final", "iterations",
                                                    "seconds", "rejected_edges"));
  EXPECT_EQ(json["poses"], 40);
  EXPECT_LT(json["chi2_final"], json["chi2_initial"]);
  const auto again = test::runScslam("optimize " + (folder / "out.g2o").string() + " --init file --json");
  EXPECT_NEAR(nlohmann::json::parse(again.out)["chi2_initial"], double(json["chi2_final"]), 1e-6);
}

TEST(OptimizeVerb, PoseByPoseEndsWhereTheBatchDoes) {
  const auto folder = test::freshFolder();
  test::SquareWalk walk(10, 3, 0.05);
  writeFileAtomically(folder / "in.g2o", formatG2o(walk.graph));
  const auto batch = test::runScslam("optimize " + (folder / "in.g2o").string() + " --json");
  const auto online = test::runScslam("optimize " + (folder / "in.g2o").string() + " --json --incremental");
  ASSERT_EQ(online.exit_code, 0) << online.err;
  EXPECT_THAT(online.err, HasSubstr("ms the worst update"));
  const auto a = nlohmann::json::parse(batch.out), b = nlohmann::json::parse(online.out);
  EXPECT_NEAR(a["chi2_initial"], double(b["chi2_initial"]), 1e-9 * double(a["chi2_initial"]));
  EXPECT_NEAR(a["chi2_final"], double(b["chi2_final"]), 1e-6 * double(a["chi2_final"]));
}

TEST(OptimizeVerb, EndsWithTheExitCodesOfTheReadme) {
  const auto folder = test::freshFolder();
  std::ofstream(folder / "bad.g2o") << "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nEDGE_SE3:QUAT 0 1 x\n";
  std::ofstream(folder / "edges.g2o") << "EDGE_SE2 0 1 1 0 0\n";
  const auto bad = test::runScslam("optimize " + (folder / "bad.g2o").string());
  EXPECT_EQ(bad.exit_code, 3);
  EXPECT_THAT(bad.err, HasSubstr("bad.g2o:2: 'x' is not a number"));
  EXPECT_EQ(bad.out, "");
  EXPECT_EQ(test::runScslam("optimize " + (folder / "none.g2o").string()).exit_code, 3);
  EXPECT_EQ(test::runScslam("optimize").exit_code, 2);
  EXPECT_EQ(test::runScslam("optimize a.g2o --robust tukey").exit_code, 2);
  EXPECT_EQ(test::runScslam("optimize " + (folder / "edges.g2o").string() + " --init file").exit_code, 2);
  EXPECT_EQ(test::runScslam("optimize " + (folder / "edges.g2o").string()).exit_code, 0);
}

}  // namespace
}  // namespace scslam
