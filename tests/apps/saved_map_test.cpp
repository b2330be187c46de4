// A session made ready to be searched: scans that are gone, sensors mounted elsewhere.
#include "scslam/apps/saved_map.h"
#include "apps/session_of.h"
#include "scslam/core/error.h"
#include "scslam/session/layout.h"
#include "session/memory_folder.h"
#include "support/support.h"

namespace scslam::test {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBytes = 1 << 20;

SessionParts parts() {
  SessionParts parts;
  parts.T_base_sensor = poseFromYaw(0.4, {0.3, -0.1, 1.7});
  for (int i = 0; i < 8; ++i) {
    parts.odometry.push_back(poseFromYaw(0.1 * i, {2.0 * i, 0.1 * i * i, 0.05 * i}));
    parts.optimised.push_back(poseFromYaw(0.5, {10, 3, 0}) * parts.odometry.back());
  }
  parts.loops = {acceptedLoop(1, 6, parts.optimised[1].inverse() * parts.optimised[6])};
  parts.cloud_sensor = [](std::size_t k) {
    Cloud cloud;
    cloud.push(static_cast<float>(k), 2, 1);
    cloud.push(5, static_cast<float>(k), -1);
    return cloud;
  };
  return parts;
}

TEST(SavedMap, ACommonBaseMovesPosesAndMeasurementsButNoPoint) {
  const SessionParts made = parts();
  const Session session = sessionOf(memoryFolder() / "s", made);
  const Pose T_base_sensor = poseFromYaw(-1.2, {1, 0.5, 0.9});  // another robot's mounting
  const SavedMap own(session, made.T_base_sensor, {}, kBytes), common(session, T_base_sensor, {}, kBytes);
  for (KeyframeId k = 0; k < 8; ++k) {
    const Cloud a = transformed(*own.cloud(k), own.poses()[k]), b = transformed(*common.cloud(k), common.poses()[k]);
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_LT((a.point(i) - b.point(i)).norm(), 1e-4) << k;
    EXPECT_THAT(Pose(common.poses()[k] * T_base_sensor), IsNear(own.poses()[k] * made.T_base_sensor, 1e-9, 1e-7));
  }
  const LoopRecord& loop = common.loops().at(0);
  EXPECT_THAT(loop.T_match_query, IsNear(common.poses()[1].inverse() * common.poses()[6], 1e-9, 1e-7));
  // The same small error of the measurement costs the same in both frames.
  Vector6d delta;
  delta << 0.01, -0.02, 0.03, 0.002, 0.001, -0.003;
  const Pose C = common.T_own_base();
  const Vector6d moved = local(Pose::Identity(), Pose(C.inverse() * retract(Pose::Identity(), delta) * C));
  EXPECT_NEAR(moved.dot(loop.information * moved), delta.dot(own.loops()[0].information * delta), 1e-3);
}

TEST(SavedMap, KeyframesOfAClassicFolderWithoutAScanAreLeftOutAndTheOthersRenumbered) {
  const fs::path folder = memoryFolder() / "s";
  sessionOf(folder, parts());
  for (const char* ours : {layout::kManifest, layout::kJournal, layout::kConfig, layout::kPoseGraph})
    fs::remove(folder / ours);
  for (const KeyframeId k : {0U, 3U}) fs::remove(layout::scanFile(folder, k));
  const SavedMap map(Session::open(folder), Pose::Identity(), {}, kBytes);
  ASSERT_EQ(map.keyframes().size(), 6u);
  EXPECT_EQ(map.keyframesWithoutScan(), 2u);
  EXPECT_EQ(map.ownNumber(2), 4u);
  EXPECT_EQ(map.cloud(2)->x[0], 4.f);
  for (KeyframeId k = 0; k < 6; ++k) EXPECT_EQ(map.keyframes()[k].id, k);
  // Two steps in one are as uncertain as two steps.
  EXPECT_NEAR(map.keyframes()[2].step_covariance(5, 5), 2 * map.keyframes()[1].step_covariance(5, 5), 1e-12);
  ASSERT_EQ(map.scans().size(), 8u);
  EXPECT_EQ(map.scans()[0].keyframe, 0);
  EXPECT_EQ(map.scans()[3].keyframe, 1);
  EXPECT_EQ(map.scans()[7].keyframe, 5);
}

TEST(SavedMap, AMissingScanOfOurOwnSessionIsNamed) {
  const fs::path folder = memoryFolder() / "s";
  const Session session = sessionOf(folder, parts());
  fs::remove(layout::scanFile(folder, 5));
  try {
    const SavedMap map(session, Pose::Identity(), {}, kBytes);
    ADD_FAILURE() << "not noticed";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("000005.pcd is missing"));
  }
}

TEST(SavedMap, TheDigestTellsSessionsApartAndKnowsACopy) {
  const fs::path folder = memoryFolder();
  SessionParts made = parts();
  const Session one = sessionOf(folder / "one", made), copy = sessionOf(folder / "copy", made);
  made.optimised[4].translation().x() += 1e-9;
  const Session other = sessionOf(folder / "other", made);
  EXPECT_EQ(contentDigest(one), contentDigest(copy));
  EXPECT_NE(contentDigest(one), contentDigest(other));
}

}  // namespace
}  // namespace scslam::test
