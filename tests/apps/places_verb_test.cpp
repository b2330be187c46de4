#include <nlohmann/json.hpp>

#include "apps/session_of.h"
#include "scslam/core/file.h"
#include "session/memory_folder.h"
#include "support/support.h"
#include "support/town.h"

namespace scslam::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// A drive more than once around a block, as a KITTI folder with its truth in poses.txt.
fs::path aDrive(double step_m) {
  const fs::path folder = memoryFolder();
  const std::vector<Pose> truth = aroundTheBlock(step_m);
  writeKittiDrive(folder, Town(), truth, withDrift(truth), 2000);
  return folder;
}

TEST(PlacesVerb, FindsTheSecondLapInAnInputWithTruth) {
  const fs::path drive = aDrive(2.0);
  const fs::path svg = drive / "places.svg";
  const RunResult run = runScslam(
      fmt::format("places {} --recogniser scan_context --variant scan_context:max_radius_m=20 --json -q --svg {}",
                  drive.string(), svg.string()));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  ASSERT_EQ(json["variants"].size(), 2u);
  EXPECT_EQ(json["keyframes_from"], "the true trajectory");
  EXPECT_GT(json["variants"][0]["revisits"], 15);
  EXPECT_GT(json["variants"][0]["recall_at_1"], 0.8);
  EXPECT_NE(json["variants"][0]["f1_threshold"], json["variants"][1]["f1_threshold"]);
  EXPECT_THAT(readFile(svg), HasSubstr("scan_context:max_radius_m=20"));
}

TEST(PlacesVerb, TakesASessionsKeyframesAndClouds) {
  const fs::path folder = memoryFolder();
  const Town town;
  SessionParts parts;
  parts.odometry = parts.optimised = aroundTheBlock(4.0);
  parts.cloud_sensor = [&](std::size_t k) { return town.scan(parts.odometry[k], static_cast<std::uint32_t>(k) + 1); };
  sessionOf(folder / "s", parts);
  writeFileAtomically(folder / "truth.txt", formatKitti(parts.odometry));
  const std::string call = "places " + (folder / "s").string() + " --json -q";
  EXPECT_EQ(runScslam(call).exit_code, 2) << "a session without --gt";
  const RunResult run = runScslam(call + " --gt " + (folder / "truth.txt").string());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json["keyframes"], parts.odometry.size());
  EXPECT_EQ(json["keyframes_from"], "the session");
}

TEST(PlacesVerb, RefusesInOneLine) {
  const fs::path drive = aDrive(8.0);
  const auto expect = [&](const std::string& flags, int code, const std::string& message) {
    const RunResult run = runScslam("places " + drive.string() + " -q " + flags);
    EXPECT_EQ(run.exit_code, code) << flags;
    EXPECT_THAT(run.err, HasSubstr(message)) << flags;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  };
  expect("--recogniser scan_contxt", 2, "did you mean 'scan_context'");
  expect("--variant scan_context:ringz=3", 2, "did you mean 'rings'");
  writeFileAtomically(drive / "short.txt", formatKitti({Pose::Identity()}));
  expect("--gt " + (drive / "short.txt").string(), 3, "has 1 poses and no times");
  writeFileAtomically(drive / "late.tum", formatTum({{stampFromSeconds(9e8), Pose::Identity()}}));
  expect("--gt " + (drive / "late.tum").string(), 3, "ground truth");
}

}  // namespace
}  // namespace scslam::test
