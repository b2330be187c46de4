#include "sim/wheel_odometry.h"

#include <gtest/gtest.h>
#include <mrpt/obs/CObservationOdometry.h>

#include "drives.h"
#include "scslam/core/error.h"

namespace scslam::sim {
namespace {

using mrpt::obs::CObservationOdometry;
using test::emitted;
using test::start;

mrpt::poses::CPose2D lastOf(const WheelOdometryModel& model, const Trajectory& trajectory, std::uint64_t seed = 1) {
  WheelOdometry wheels(model, trajectory, seed, start());
  return emitted<CObservationOdometry>(wheels).back()->odometry;
}

TEST(WheelOdometry, StartsAtTheIdentityWhereverTheRobotIs) {
  const Trajectory trajectory = test::parked(1, poseFromYaw(1, {10, 20, 30}));
  WheelOdometry wheels({}, trajectory, 1, start());
  const auto all = emitted<CObservationOdometry>(wheels);
  ASSERT_EQ(all.size(), 21U);
  EXPECT_EQ(all[0]->timestamp, start());
  EXPECT_EQ(all[0]->odometry, mrpt::poses::CPose2D(0, 0, 0));
}

TEST(WheelOdometry, StaysWhereItIsWhileParked) {
  EXPECT_EQ(lastOf({}, test::parked(600)), mrpt::poses::CPose2D(0, 0, 0));
}

TEST(WheelOdometry, ScaleIsExactlyAsSet) {
  WheelOdometryModel model = WheelOdometryModel().perfect();
  for (double scale : {0.0, 0.03, -0.02}) {
    model.scale_error = scale;
    const auto T = lastOf(model, test::straight(10, 20));
    EXPECT_NEAR(T.x(), 200 * (1 + scale), 1e-9);
    EXPECT_NEAR(T.y(), 0, 1e-9);
    EXPECT_NEAR(T.phi(), 0, 1e-12);
  }
}

TEST(WheelOdometry, PathOnASlopeIsItsLengthNotItsPlan) {
  std::vector<Pose> control;
  for (int i = 0; i < 4; ++i) control.push_back(poseFromYaw(0, {40.0 * (i - 1), 0, 30.0 * (i - 1)}));
  EXPECT_NEAR(lastOf(WheelOdometryModel().perfect(), Trajectory(control, 10)).x(), 50, 1e-9);
}

TEST(WheelOdometry, ReversingGoesBack) {
  const auto T = lastOf(WheelOdometryModel().perfect(), test::straight(-5, 10));
  EXPECT_NEAR(T.x(), -50, 1e-9);
}

constexpr double kTurnIn16s = 2 * M_PI * 20 / 16;  // [m/s] on a radius of 20 m: the last sample is at the end

TEST(WheelOdometry, ClosesACircleAndTurnsTooFarByTheYawScale) {
  WheelOdometryModel model = WheelOdometryModel().perfect();
  const Trajectory trajectory = test::circle(20, kTurnIn16s, 1);
  const auto exact = lastOf(model, trajectory);
  EXPECT_NEAR(std::hypot(exact.x(), exact.y()), 0, 1e-3);
  EXPECT_NEAR(exact.phi(), 0, 1e-9);
  model.yaw_scale_error = 0.02;
  EXPECT_NEAR(lastOf(model, trajectory).phi(), 0.02 * 2 * M_PI, 1e-9);
}

TEST(WheelOdometry, HalfACircleEndsAtItsDiameter) {
  const auto T = lastOf(WheelOdometryModel().perfect(), test::circle(20, kTurnIn16s, 0.5));
  EXPECT_NEAR(T.x(), 0, 0.01);
  EXPECT_NEAR(T.y(), 40, 0.01);
  EXPECT_NEAR(std::abs(T.phi()), M_PI, 1e-6);
}

TEST(WheelOdometry, UnequalWheelsTurnByTheDistance) {
  WheelOdometryModel model = WheelOdometryModel().perfect();
  model.yaw_bias_deg_per_m = 0.1;
  for (double speed : {5.0, 20.0})
    EXPECT_NEAR(lastOf(model, test::straight(speed, 300 / speed)).phi(), 30 * M_PI / 180, 1e-9);
}

TEST(WheelOdometry, SlipGrowsWithTheRootOfTheDistanceAtAnyRate) {
  const Trajectory trajectory = test::straight(10, 40);
  for (double rate : {5.0, 20.0}) {
    WheelOdometryModel model = WheelOdometryModel().perfect();
    model.rate_hz = rate;
    model.slip_m_per_sqrt_m = 0.02;
    std::vector<double> at_100_m, at_400_m, yaw;
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
      WheelOdometry wheels(model, trajectory, seed, start());
      at_100_m.push_back(emitted<CObservationOdometry>(wheels, 10).back()->odometry.x());
      at_400_m.push_back(emitted<CObservationOdometry>(wheels).back()->odometry.x());
    }
    EXPECT_MOMENTS(at_100_m, 100, 0.2);
    EXPECT_MOMENTS(at_400_m, 400, 0.4);
    model.slip_deg_per_sqrt_m = 0.05;
    for (std::uint64_t seed = 0; seed < 300; ++seed) yaw.push_back(lastOf(model, trajectory, seed).phi());
    EXPECT_MOMENTS(yaw, 0, 1.0 * M_PI / 180);
  }
}

TEST(WheelOdometry, QuantisationNeverLosesMoreThanATick) {
  const Trajectory trajectory = test::straight(3.3337, 30);
  WheelOdometryModel model = WheelOdometryModel().perfect();
  model.tick_m = 0.05;
  WheelOdometry wheels(model, trajectory, 1, start());
  bool off = false;
  for (const auto& o : emitted<CObservationOdometry>(wheels)) {
    const double truth = 3.3337 * secondsBetween(start(), o->timestamp);
    EXPECT_NEAR(o->odometry.x(), truth, 0.5001 * 0.05);
    EXPECT_TRUE(o->hasEncodersInfo);
    EXPECT_EQ(o->encoderLeftTicks, std::lround(o->odometry.x() / 0.05));
    EXPECT_EQ(o->encoderRightTicks, o->encoderLeftTicks);
    off = off || std::abs(o->odometry.x() - truth) > 0.01;
  }
  EXPECT_TRUE(off) << "nothing was quantised";
}

TEST(WheelOdometry, VelocityIsThatOfTheDrive) {
  const Trajectory trajectory = test::circle(20, 8, 0.1);
  WheelOdometry wheels(WheelOdometryModel().perfect(), trajectory, 1, start());
  const auto all = emitted<CObservationOdometry>(wheels);
  for (std::size_t k = 1; k < all.size(); ++k) {
    EXPECT_NEAR(all[k]->velocityLocal.vx, 8, 1e-3);
    EXPECT_NEAR(all[k]->velocityLocal.omega, 0.4, 1e-6);
  }
}

TEST(WheelOdometry, SameSeedSamePosesHoweverTheLoopAsks) {
  const Trajectory trajectory = test::lively();
  WheelOdometry at_once({}, trajectory, 4, start()), in_steps({}, trajectory, 4, start()),
      other({}, trajectory, 5, start());
  const auto a = emitted<CObservationOdometry>(at_once), c = emitted<CObservationOdometry>(other);
  std::vector<std::shared_ptr<const CObservationOdometry>> b;
  for (double t = 0; t < 31; t += 0.77)
    for (const auto& o : emitted<CObservationOdometry>(in_steps, t)) b.push_back(o);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) EXPECT_EQ(a[k]->odometry, b[k]->odometry);
  EXPECT_NE(a.back()->odometry, c.back()->odometry);
}

TEST(WheelOdometry, DefaultsDriftByAboutAPercent) {
  const Trajectory trajectory = test::straight(10, 100);
  const auto T = lastOf({}, trajectory);
  const double off = std::hypot(T.x() - 1000, T.y());
  EXPECT_GT(off, 1);
  EXPECT_LT(off, 200);
}

}  // namespace
}  // namespace scslam::sim
