#include <cmath>

#include "scslam/keyframe/selector.h"
#include "scslam/keyframe/submap.h"
#include "support/support.h"

namespace scslam {
namespace {

using test::IsNear;

Matrix6d stepCovariance() { return Matrix6d::Identity() * 1e-6; }

TEST(KeyframeSelector, TakesTheFirstScanThenEveryMetre) {
  KeyframeSelector selector(KeyframeParams{});
  std::vector<double> taken;
  for (int i = 0; i <= 40; ++i) {
    Keyframe keyframe;
    if (selector.isDue(poseFromYaw(0, {0.25 * i, 0, 0}), stepCovariance())) {
      selector.accept(keyframe);
      taken.push_back(keyframe.travelled_m);
    }
  }
  EXPECT_EQ(taken, (std::vector<double>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10}));
}

TEST(KeyframeSelector, StandingWithJitterMakesNoKeyframe) {
  KeyframeSelector selector(KeyframeParams{});
  int taken = 0;
  for (int i = 0; i < 10000; ++i) {
    const Pose T = poseFromYaw(0.02 * std::sin(i), {0.2 * std::sin(1.7 * i), 0.2 * std::cos(i), 0});
    Keyframe keyframe;
    if (selector.isDue(T, stepCovariance())) selector.accept(keyframe), ++taken;
  }
  EXPECT_EQ(taken, 1);
}

TEST(KeyframeSelector, TurningOnTheSpotMakesKeyframes) {
  KeyframeSelector selector(KeyframeParams{});
  int taken = 0;
  for (int i = 0; i < 360; ++i) {
    Keyframe keyframe;
    if (selector.isDue(poseFromYaw(i * M_PI / 180, {0, 0, 0}), stepCovariance())) selector.accept(keyframe), ++taken;
  }
  EXPECT_EQ(taken, 360 / 15);
}

TEST(KeyframeSelector, CovarianceGrowsWithTheStepsInBetweenAndLeversRotation) {
  KeyframeParams params;
  params.distance_m = 10;
  KeyframeSelector selector(params);
  Keyframe first, second;
  selector.isDue(Pose::Identity(), Matrix6d::Zero());
  selector.accept(first);
  for (int i = 1; i <= 10; ++i) selector.isDue(poseFromYaw(0, {1.0 * i, 0, 0}), stepCovariance());
  selector.accept(second);
  EXPECT_NEAR(second.step_covariance(5, 5), 10e-6, 1e-12);
  double lateral = 0;  // 1e-6 from each step, and yaw errors of 1e-6 levered over what remains of the way
  for (int i = 1; i <= 10; ++i) lateral += 1e-6 + 1e-6 * (10 - i) * (10 - i);
  EXPECT_NEAR(second.step_covariance(1, 1), lateral, 1e-10);
}

TEST(KeyframeSelector, GoesOnIdenticallyFromASavedState) {
  KeyframeSelector a(KeyframeParams{}), b(KeyframeParams{});
  Keyframe keyframe;
  a.isDue(Pose::Identity(), stepCovariance());
  a.accept(keyframe);
  a.isDue(poseFromYaw(0.1, {0.7, 0, 0}), stepCovariance());
  ByteWriter writer;
  a.save(writer);
  ByteReader reader(writer.bytes());
  b.load(reader);
  Keyframe from_a, from_b;
  EXPECT_EQ(a.isDue(poseFromYaw(0.1, {1.1, 0, 0}), stepCovariance()),
            b.isDue(poseFromYaw(0.1, {1.1, 0, 0}), stepCovariance()));
  a.accept(from_a), b.accept(from_b);
  EXPECT_EQ(from_a.travelled_m, from_b.travelled_m);
  EXPECT_EQ(from_a.step_covariance, from_b.step_covariance);
}

std::vector<Keyframe> aRow(int n, double gap) {
  std::vector<Keyframe> row(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i)
    row[static_cast<std::size_t>(i)].id = static_cast<KeyframeId>(i),
    row[static_cast<std::size_t>(i)].travelled_m = gap * i;
  return row;
}

TEST(Submap, MembersLieWithinReachAndBelowTheLimit) {
  auto row = aRow(20, 2);
  EXPECT_EQ(submapMembers(row, 10, 20, 5, 10), (std::vector<KeyframeId>{8, 9, 10, 11, 12}));
  EXPECT_EQ(submapMembers(row, 10, 12, 5, 10), (std::vector<KeyframeId>{8, 9, 10, 11}));
  EXPECT_EQ(submapMembers(row, 10, 20, 100, 1), (std::vector<KeyframeId>{9, 10, 11}));
  EXPECT_EQ(submapMembers(row, 0, 20, 3, 10), (std::vector<KeyframeId>{0, 1}));
  row[12].step_covariance.diagonal().setConstant(9);  // carried away, nobody knows where to
  EXPECT_EQ(submapMembers(row, 10, 20, 5, 10), (std::vector<KeyframeId>{8, 9, 10, 11}));
  EXPECT_EQ(submapMembers(row, 13, 20, 5, 10), (std::vector<KeyframeId>{12, 13, 14, 15}));
}

TEST(Submap, EveryScanStandsAtItsOwnPose) {
  // One landmark seen from three poses must come out as one point, whatever the centre's own pose.
  const Eigen::Vector3d p_map(5, 3, 1);
  const std::vector<Pose> T_map_base = {poseFromYaw(0.3, {0, 0, 0}), poseFromYaw(0.8, {2, 1, 0.5}),
                                        poseFromYaw(-2, {4, 1, 0})};
  const auto cloud_of = [&](KeyframeId k) {
    auto cloud = std::make_shared<Cloud>();
    const Eigen::Vector3f p = (T_map_base[k].inverse() * p_map).cast<float>();
    cloud->push(p.x(), p.y(), p.z());
    return cloud;
  };
  const Cloud submap = joined(placedScans({0, 1, 2}, 1, T_map_base, cloud_of));
  const Eigen::Vector3f expected = (T_map_base[1].inverse() * p_map).cast<float>();
  ASSERT_EQ(submap.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_LT((submap.point(i) - expected).norm(), 1e-5);
}

}  // namespace
}  // namespace scslam
