// The simulator's scans against figures of real ones: the commands of README, every goal met.
#include <nlohmann/json.hpp>

#include "support/support.h"

namespace scslam {
namespace {

std::map<std::string, std::pair<double, double>> scores(const std::string& simulated, const std::string& like) {
  const auto log = test::freshFolder() / "drive.rawlog";
  const test::RunResult sim = test::runScslam("sim " + simulated + " -q -o " + log.string());
  EXPECT_EQ(sim.exit_code, 0) << sim.err;
  const test::RunResult realism = test::runScslam("realism " + log.string() + " --like " + like + " --json");
  EXPECT_EQ(realism.exit_code, 0) << realism.err;
  std::map<std::string, std::pair<double, double>> scores;
  const nlohmann::json told = nlohmann::json::parse(realism.out);
  for (const auto& score : told["scores"])
    if (score["value"].is_number()) scores[score["name"]] = {score["value"], score["goal"]};
  return scores;
}

TEST(SimulatedScans, OfGreenStreetsAreLikeThoseOfKaist03) {
  const auto found = scores(SCSLAM_SOURCE_DIR "/maps/campus.yaml", "kaist03_os1-64");
  ASSERT_EQ(found.size(), 6u);
  for (const auto& [name, score] : found) EXPECT_GE(score.first, score.second) << name;
}

// What is lost by strength, too, can only be held against a set with true strengths; its unit has its own elevations.
TEST(SimulatedScans, LoseEchoesByStrengthAsThoseOfSeosan01Do) {
  const auto found = scores("s02 --set drive.duration_s=10 --set lidar.sensor=os1-128", "seosan01_os1-128");
  EXPECT_GE(found.at("drop-out").first, 0.7);
}

}  // namespace
}  // namespace scslam
