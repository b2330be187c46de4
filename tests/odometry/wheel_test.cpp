#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "odometry/drive.h"
#include "scslam/odometry/odometry.h"

namespace scslam {
namespace {

using test::Drive;
using test::IsNear;
using ::testing::HasSubstr;

std::unique_ptr<Odometry> wheel() { return Registry<Odometry>::instance().create("wheel", test::context()); }

/// What was reported for each scan.
std::vector<OdometryStep> driven(const Drive& drive) {
  const auto odometry = wheel();
  std::vector<OdometryStep> steps;
  for (const Scan& scan : drive.scans) steps.push_back(odometry->step(scan));
  return steps;
}

Pose sinceFirst(const Drive& drive, std::size_t k) { return drive.T_world_base[0].inverse() * drive.T_world_base[k]; }

TEST(Wheel, CountsTheStepsOfTheRecordingFromItsOwnOrigin) {
  const Drive drive = test::arc(8);
  const std::vector<OdometryStep> steps = driven(drive);
  for (std::size_t k = 0; k < steps.size(); ++k) {
    EXPECT_TRUE(steps[k].quality.ok);
    EXPECT_THAT(steps[k].T_odom_base, IsNear(sinceFirst(drive, k), 1e-9, 1e-7)) << k;
  }
}

TEST(Wheel, AGapIsSaidAndMadeGoodWhenTheWheelsAreBack) {
  Drive drive = test::arc(12);
  for (std::size_t k = 5; k < 8; ++k) drive.scans[k].T_odom_base.reset();
  const std::vector<OdometryStep> steps = driven(drive);
  for (std::size_t k = 5; k < 8; ++k) {
    EXPECT_FALSE(steps[k].quality.ok);
    EXPECT_THAT(steps[k].quality.note, HasSubstr("no wheel odometry"));
    EXPECT_GT(steps[k].covariance(0, 0), 9 * steps[4].covariance(0, 0));
    EXPECT_THAT(steps[k].T_odom_base, IsNear(sinceFirst(drive, k), 0.01, 0.1)) << "an arc at constant speed";
  }
  EXPECT_THAT(steps[11].T_odom_base, IsNear(sinceFirst(drive, 11), 1e-9, 1e-7));
}

TEST(Wheel, EncodersThatStartAnewAreNoLeapOfTheRobot) {
  Drive drive = test::arc(12);
  for (std::size_t k = 0; k < 6; ++k) drive.scans[k].T_odom_base = poseFromYaw(0, {500, 0, 0}) * drive.T_world_base[k];
  const std::vector<OdometryStep> steps = driven(drive);
  EXPECT_FALSE(steps[6].quality.ok);
  EXPECT_THAT(steps[6].quality.note, HasSubstr("leaps by 499.9 m"));
  EXPECT_TRUE(steps[7].quality.ok);
  EXPECT_THAT(steps[11].T_odom_base, IsNear(sinceFirst(drive, 11), 0.01, 0.1));
}

TEST(Wheel, CompensatesTheSweepByItsOwnSpeed) {
  Drive drive = test::arc(3);
  Scan& last = drive.scans[2];
  const Cloud still = transformed(last.cloud, last.T_base_sensor);
  const Vector6d twist = local(drive.T_world_base[1], drive.T_world_base[2]) / 0.1;
  for (std::size_t i = 0; i < last.cloud.size(); ++i) {
    const double dt = 0.1 * static_cast<double>(i) / static_cast<double>(last.cloud.size());
    const Pose T_then_now = retract(Pose::Identity(), dt * twist).inverse();
    const Eigen::Vector3f p = (last.T_base_sensor.inverse() * T_then_now * still.point(i).cast<double>()).cast<float>();
    last.cloud.x[i] = p.x(), last.cloud.y[i] = p.y(), last.cloud.z[i] = p.z();
    last.cloud.dt.push_back(static_cast<float>(dt));
  }
  const Cloud cloud = driven(drive)[2].cloud;
  ASSERT_EQ(cloud.size(), still.size());
  for (std::size_t i = 0; i < still.size(); i += 97) EXPECT_LT((cloud.point(i) - still.point(i)).norm(), 2e-3f) << i;
}

TEST(Wheel, KnowsLeastOfSlopesAndLessOfALongerStep) {
  Drive drive = test::arc(3);
  drive.scans[2].T_odom_base = *drive.scans[1].T_odom_base * poseFromYaw(0, {1.5, 0, 0});
  const std::vector<OdometryStep> steps = driven(drive);
  EXPECT_GT(steps[2].covariance(0, 0), 4 * steps[1].covariance(0, 0));
  EXPECT_GT(steps[2].covariance(2, 2), steps[2].covariance(0, 0)) << "up, along";
  EXPECT_GT(steps[2].covariance(4, 4), steps[2].covariance(5, 5)) << "pitch, yaw";
}

TEST(Wheel, ARecordingWithoutOdometryIsOneClearLine) {
  Drive drive = test::arc(1);
  drive.scans[0].T_odom_base.reset();
  try {
    driven(drive);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("has no wheel odometry"));
    EXPECT_THAT(error.what(), HasSubstr("--odometry voxel_icp needs none"));
  }
}

// Wheels as a prior of another front-end: a corridor whose ends are out of sight, standing still after some way.
class WheelPrior : public ::testing::TestWithParam<std::string> {};

Scan inCorridor(std::size_t index, double x) {
  Scan scan;
  scan.index = index;
  scan.stamp = stampFromSeconds(1000.0 + 0.1 * static_cast<double>(index));
  std::mt19937 random(static_cast<std::uint32_t>(index) + 1);
  const auto uniform = [&random] { return static_cast<float>(random()) / 4294967296.0f; };
  for (int i = 0; i < 8000; ++i) {
    const float along = 40 * uniform() - 20, across = 3 * uniform() - 1.5f, noise = 0.02f * (uniform() - 0.5f);
    if (i % 4 == 0) scan.cloud.push(along, across, -1.5f + noise);
    if (i % 4 == 1) scan.cloud.push(along, across, 1.5f + noise);
    if (i % 4 == 2) scan.cloud.push(along, 1.5f + noise, across);
    if (i % 4 == 3) scan.cloud.push(along, -1.5f + noise, across);
  }
  scan.T_odom_base = poseFromYaw(0, {x, 0, 0});
  return scan;
}

TEST_P(WheelPrior, CarriesThroughACorridor) {
  const auto with = Registry<Odometry>::instance().create(GetParam(), test::context());
  const auto without = Registry<Odometry>::instance().create(GetParam(), test::context());
  Pose T_with, T_without;
  double x = 0;
  for (std::size_t k = 0; k < 60; ++k) {
    Scan scan = inCorridor(k, x);
    T_with = with->step(scan).T_odom_base;
    scan.T_odom_base.reset();
    T_without = without->step(scan).T_odom_base;
    if (k < 40) x += 0.2 * (1 - std::cos(0.3 * static_cast<double>(k)));
  }
  EXPECT_NEAR(T_with.translation().x(), x, 0.02 * x);
  EXPECT_GT(std::abs(T_without.translation().x() - x), 1) << "the test must tell";
}

INSTANTIATE_TEST_SUITE_P(FrontEnds, WheelPrior, ::testing::Values("voxel_icp", "gicp", "lio", "lio_smoother"),
                         [](const auto& tested) { return tested.param; });

}  // namespace
}  // namespace scslam
