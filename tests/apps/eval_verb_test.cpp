#include <nlohmann/json.hpp>

#include "apps/session_of.h"
#include "scslam/core/file.h"
#include "session/memory_folder.h"
#include "support/support.h"

namespace scslam::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

struct Case {
  fs::path folder = memoryFolder();
  std::string session = (folder / "s").string(), truth = (folder / "truth.txt").string();
  Case() {
    SessionParts parts;
    parts.T_base_sensor = poseFromYaw(0.5, {1, 0, 1.5});
    std::vector<Pose> sensor;
    for (int i = 0; i < 30; ++i) {
      parts.optimised.push_back(poseFromYaw(0.1 * i, {2.0 * i, 0.02 * i * i, 0}));
      sensor.push_back(parts.optimised.back() * parts.T_base_sensor);
      parts.odometry.push_back(poseFromYaw(0.1 * i, {2.2 * i, 0.02 * i * i, 0}));
    }
    sessionOf(session, parts);
    writeFileAtomically(truth, formatKitti(parts.optimised));
    writeFileAtomically(folder / "sensor.txt", formatKitti(sensor));
  }
};

TEST(EvalVerb, PrintsOneJsonObjectAndNothingElse) {
  const Case c;
  const RunResult run = runScslam("eval " + c.session + " --gt " + c.truth + " --json");
  EXPECT_EQ(run.exit_code, 0);
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_NEAR(json["trajectory"]["ate_rmse_m"], 0, 1e-9);
  EXPECT_GT(json["trajectory"]["odometry_ate_rmse_m"], 1.0);
}

TEST(EvalVerb, TruthOfTheSensorIsMovedToTheBase) {
  const Case c;
  const std::string call = "eval " + c.session + " --json --gt " + (c.folder / "sensor.txt").string();
  EXPECT_NEAR(nlohmann::json::parse(runScslam(call + " --gt-frame sensor").out)["trajectory"]["ate_rmse_m"], 0, 1e-9);
  EXPECT_GT(nlohmann::json::parse(runScslam(call).out)["trajectory"]["ate_rmse_m"], 0.1);
}

TEST(EvalVerb, GateEndsInFive) {
  const Case c;
  writeFileAtomically(c.truth, readFile(c.folder / "sensor.txt"));
  EXPECT_EQ(runScslam("eval " + c.session + " --gt " + c.truth + " --max-ate 100").exit_code, 0);
  const RunResult run = runScslam("eval " + c.session + " --gt " + c.truth + " --max-ate 0.01");
  EXPECT_EQ(run.exit_code, 5);
  EXPECT_THAT(run.err, HasSubstr("more than 0.01 m"));
}

TEST(EvalVerb, RowsThatDoNotAgreeEndInThreeWithBothCounts) {
  const Case c;
  writeFileAtomically(c.truth, formatKitti(std::vector<Pose>(12, Pose::Identity())));
  const RunResult run = runScslam("eval " + c.session + " --gt " + c.truth);
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, ::testing::AllOf(HasSubstr("12 poses"), HasSubstr("30 scans")));
}

}  // namespace
}  // namespace scslam::test
