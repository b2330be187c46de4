#include <cstdlib>
#include <nlohmann/json.hpp>

#include "scslam/core/file.h"
#include "session/memory_folder.h"
#include "support/support.h"
#include "support/town.h"

namespace scslam::test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

struct Drive {
  fs::path root = memoryFolder(), folder = root / "drive";
  Drive() {
    std::vector<Pose> truth = aroundTheBlock(0.8);
    truth.resize(25);
    writeKittiDrive(folder, Town(), truth, withDrift(truth, 0.5, 1.05), 500);
  }
  RunResult compare(const std::string& flags) const { return runScslam("compare " + folder.string() + " -q " + flags); }
};

TEST(CompareVerb, PutsRunsSideBySideAndKeepsTheSessions) {
  const Drive drive;
  fs::create_directories(drive.root / "again");
  fs::copy(drive.folder, drive.root / "again" / "drive", fs::copy_options::recursive);
  const fs::path out = drive.root / "out";
  const RunResult run =
      drive.compare(fmt::format("{} --odometry poses --poses {} --json -o {}", (drive.root / "again/drive").string(),
                                (drive.folder / "odometry.txt").string(), out.string()));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto runs = nlohmann::json::parse(run.out)["runs"];
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0]["input"], "drive");
  EXPECT_EQ(runs[1]["input"], "drive (2)");
  for (const auto& r : runs) {
    EXPECT_TRUE(r["failure"].is_null()) << r["failure"];
    EXPECT_GT(r["cpu_ms_per_scan"], 0);
    EXPECT_GT(r["peak_rss_mb"], 10);
    EXPECT_EQ(r["step_nees"]["steps"], r["keyframes"].get<int>() - 1);
    EXPECT_GT(r["trajectory"]["odometry_ate_rmse_m"], 0.1) << "the drift that was put in";
  }
  EXPECT_EQ(runs[0]["trajectory"], runs[1]["trajectory"]);
  for (const char* name : {"compare.json", "compare.md", "drive.poses.session/trajectory.tum"})
    EXPECT_TRUE(fs::exists(out / name)) << name;
  EXPECT_THAT(readFile(out / "compare.svg"), AllOf(HasSubstr("drive (2)"), HasSubstr("</svg>")));
}

TEST(CompareVerb, AFailureIsARowAndTheOthersGoOn) {
  const Drive drive;
  writeFileAtomically(drive.root / "short.txt", formatKitti({Pose::Identity()}));
  const std::string flags = "--no-loops --max 1 --poses " + (drive.root / "short.txt").string();
  const RunResult run = drive.compare(flags + " --markdown --odometry poses,voxel_icp");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("| drive | poses     |"), HasSubstr("exit 3: "), HasSubstr("1 poses"),
                             HasSubstr("| off "), HasSubstr("| none ")));
  EXPECT_EQ(drive.compare(flags + " --odometry poses").exit_code, 3) << "nothing came out at all";
}

TEST(CompareVerb, SimulatesScenariosAndLeavesNothingBehind) {
  const fs::path temporary = memoryFolder();
  ::setenv("TMPDIR", temporary.c_str(), 1);
  const RunResult run = runScslam(
      "compare -q --scenarios s17 --odometry voxel_icp --no-loops --json --sim-set drive.duration_s=2 "
      "--sim-set lidar.sensor=vlp16");
  ASSERT_EQ(run.exit_code, 0) << run.err << run.out;
  const auto runs = nlohmann::json::parse(run.out)["runs"];
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_EQ(runs[0]["input"], "s17_standing");
  EXPECT_GT(runs[0]["scans"], 10);
  ::unsetenv("TMPDIR");
  EXPECT_TRUE(fs::is_empty(temporary));
}

TEST(CompareVerb, RefusesInOneLine) {
  const auto expect = [](const std::string& flags, const std::string& message) {
    const RunResult run = runScslam("compare " + flags);
    EXPECT_EQ(run.exit_code, 2) << flags;
    EXPECT_THAT(run.err, HasSubstr(message)) << flags;
  };
  expect("", "compare what?");
  expect("x.rawlog --odometry voxel_icq", "did you mean 'voxel_icp'");
  expect("--scenarios s99", "s99");
  expect("x.rawlog y.rawlog --gt z.tum", "1 files for 2 inputs");
  expect("x.rawlog --json --markdown", "one of them");
}

}  // namespace
}  // namespace scslam::test
