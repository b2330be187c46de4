// Found without a start pose, tracked, lost and found; never somewhere else.
#include "apps/kitti_halves.h"
#include "scslam/apps/localize/localize.h"
#include "scslam/core/counter_random.h"
#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/mapping/map_builder.h"

namespace scslam::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

LocalizeOptions optionsFor(const TownSession& map, const TownSession& drive, const fs::path& output) {
  LocalizeOptions options;
  options.session = map.folder;
  options.input = drive.input.string();
  options.sets = {"odometry.frontend=poses", "odometry.poses.file=\"" + (drive.input / "odometry.txt").string() + "\""};
  options.output = output;
  options.truth = drive.truth;
  options.session_truth = map.truth;
  options.quiet = true;
  return options;
}

TEST(Localize, AnotherDriveIsFoundByItsSecondScanAndTracked) {
  const ThreeDrives& drives = threeDrives();
  const LocalizeOptions options = optionsFor(drives.first, drives.second, freshFolder() / "l");
  const LocalizeSummary summary = localize(options, context(2));
  EXPECT_EQ(summary.scans, drives.second.T_world_base.size());
  EXPECT_LE(summary.first_fix_scan.value_or(99), 2u);
  EXPECT_GT(summary.tracked, 0.9 * static_cast<double>(summary.scans));
  EXPECT_EQ(summary.error->wrong, 0u);
  EXPECT_LT(summary.error->rmse_m, 0.12);
  EXPECT_EQ(readTrajectory(options.output.string() + ".tum").poses.size(), summary.tracked);
  const std::string csv = readFile(options.output.string() + ".csv");
  EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')), summary.scans + 1);
}

TEST(Localize, AMapMadeByOthersServesAsWell) {
  const ThreeDrives& drives = threeDrives();
  const fs::path folder = freshFolder();
  exportMap(Session::open(drives.first.folder), {"pcd"}, {}, folder, context(2));
  LocalizeOptions options = optionsFor(drives.first, drives.second, folder / "l");
  options.session = folder / "map.pcd";
  options.session_truth = fs::path();
  const LocalizeSummary summary = localize(options, context(2));
  EXPECT_LE(summary.first_fix_scan.value_or(99), 4u);
  EXPECT_GT(summary.tracked, 0.8 * static_cast<double>(summary.scans));
  EXPECT_LT(summary.error->rmse_m, 0.2);
  EXPECT_FALSE(fs::exists(folder / "l.maps.partial"));
}

TEST(Localize, SameBytesForAnyNumberOfThreads) {
  const ThreeDrives& drives = threeDrives();
  LocalizeOptions options = optionsFor(drives.first, drives.second, freshFolder() / "one");
  options.max = 12;
  localize(options, context(1));
  const std::string one = readFile(options.output.string() + ".csv");
  options.output = freshFolder() / "two";
  localize(options, context(2));
  EXPECT_EQ(readFile(options.output.string() + ".csv"), one);
}

TEST(Localize, ADriveElsewhereIsNeverFound) {
  const ThreeDrives& drives = threeDrives();
  LocalizeOptions options = optionsFor(drives.first, drives.elsewhere, freshFolder() / "l");
  options.truth = options.session_truth = fs::path();
  const LocalizeSummary summary = localize(options, context(2));
  EXPECT_EQ(summary.tracked, 0u);
  EXPECT_FALSE(summary.first_fix_scan);
}

/// Carried off twice while the odometry goes on as if nothing had happened.
TEST(Localize, AKidnappedRobotIsFoundAgainAndNeverBelievedElsewhere) {
  const ThreeDrives& drives = threeDrives();
  const auto& truth = drives.second.T_world_base;
  std::vector<Pose> jumping;
  for (std::size_t i = 0; i < 8; ++i) jumping.push_back(truth[i]);
  for (std::size_t i = 30; i < 40; ++i) jumping.push_back(truth[i]);
  for (std::size_t i = 12; i < 22; ++i) jumping.push_back(truth[i]);
  std::vector<Pose> smooth = {Pose::Identity()};
  for (std::size_t i = 1; i < jumping.size(); ++i) {
    const Pose T_step = jumping[i - 1].inverse() * jumping[i];
    smooth.push_back(smooth.back() * (T_step.translation().norm() > 5 ? Pose::Identity() : T_step));
  }
  const fs::path folder = freshFolder();
  const TownSession drive{{}, folder / "in", folder / "in" / "poses.txt", jumping};
  writeKittiDrive(drive.input, Town(1), jumping, smooth);
  const LocalizeSummary summary = localize(optionsFor(drives.first, drive, folder / "l"), context(2));
  EXPECT_EQ(summary.fixes, 3u);
  EXPECT_EQ(summary.error->wrong, 0u);
  EXPECT_GE(summary.tracked, jumping.size() - 1 - 2 * 3);
}

TEST(Localize, BadInputEndsInOneClearLineAndWritesNothing) {
  const ThreeDrives& drives = threeDrives();
  const fs::path folder = freshFolder();
  const std::string good = drives.first.folder.string(), input = drives.second.input.string();
  const auto call = [&](const std::string& arguments, int code) {
    const RunResult result = runScslam("localize " + arguments + " -o " + (folder / "l").string());
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_FALSE(fs::exists(folder / "l.tum"));
    return result.err;
  };
  EXPECT_THAT(call(good, 2), HasSubstr("SESSION and INPUT"));
  EXPECT_THAT(call(good + " " + (folder / "none").string(), 3), HasSubstr("does not exist"));
  EXPECT_THAT(call((folder / "none").string() + " " + input, 3), HasSubstr("does not exist"));
  EXPECT_THAT(call(good + " " + input + " --skip 999", 3), HasSubstr("no scans after those skipped"));
  EXPECT_THAT(call(good + " " + input + " --set localize.agree=3", 2), HasSubstr("agree_m"));
}

/// Every start is another place, another heading of the robot and another part of the scan's points.
TEST(Localize, OnARealStreetNearlyEveryStartIsFoundWithinThreeScansAndNoneIsFoundElsewhere) {
  SCSLAM_NEEDS_DATA(recording, "kitti00_kf000-039");
  constexpr std::size_t kStarts = 40;
  const KittiHalves halves = kittiHalves(recording, freshFolder());
  const SavedMap map(Session::open(halves.even.folder), Pose::Identity(), RegistrationParams{}, std::size_t{1} << 28);
  Localiser localiser(map, SlamParams(), LocalizeParams(), context(2));
  RandomSequence random(CounterRandom(7, RandomStream::kWorld));
  std::size_t found = 0;
  for (std::size_t start = 0; start < kStarts; ++start) {
    const std::size_t first = start % (halves.odd.T_world_base.size() - 2);
    const Pose T_base_turned = poseFromYaw(2 * M_PI * random.uniform(), {0, 0, 0});
    localiser.reset();
    for (std::size_t k = first; k < first + 3; ++k) {
      OdometryStep step;
      step.T_odom_base = halves.odd.T_world_base[first].inverse() * halves.odd.T_world_base[k] * T_base_turned;
      step.covariance = 1e-4 * Matrix6d::Identity();
      step.cloud = kittiScan(recording, 2 * k + 1);
      std::vector<std::uint8_t> keep(step.cloud.size());
      for (std::size_t i = 0; i < keep.size(); ++i) keep[i] = random.uniform() < 0.8;
      step.cloud.filter(keep);
      transformInPlace(step.cloud, T_base_turned.inverse());
      const Whereabouts where = localiser.step(step);
      if (where.state == WhereState::kSearching) continue;
      const KeyframeId near = *where.keyframe;
      const Pose T_true = halves.even.T_world_base[near].inverse() * halves.odd.T_world_base[k] * T_base_turned;
      EXPECT_THAT(Pose(map.poses()[near].inverse() * where.T_map_base), IsNear(T_true, 0.5, 2.0)) << "start " << start;
      ++found;
      break;
    }
  }
  EXPECT_GE(found, kStarts * 95 / 100);
}

}  // namespace
}  // namespace scslam::test
