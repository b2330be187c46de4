#include "scslam/odometry/imu_smoother.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "odometry/lio_drive.h"
#include "scslam/odometry/imu_filter.h"

namespace scslam {
namespace {

using Eigen::Vector3d;
using test::IsNear;

// ---- the residuals ----

using NodeError = Eigen::Matrix<double, ImuNode::kSize, 1>;

ImuNode nodeAt(double yaw, const Vector3d& p) {
  ImuNode node;
  node.nav = {poseFromYaw(yaw, p).linear() * so3Exp({0.2, -0.3, 0}), p, {3, -1, 0.4}};
  node.bias = {{0.01, -0.02, 0.015}, {0.1, 0.05, -0.08}};
  return node;
}

ImuPreintegration somewhereElseIntegrated() {
  std::vector<ImuReading> readings;
  for (int i = 0; i <= 20; ++i) {
    const double t = 0.01 * i;
    readings.push_back({t, {0.5 + t, -0.8 * std::cos(9 * t), 1.2}, {2 * std::sin(7 * t), 1 - 3 * t, 9 + t}});
  }
  return {readings, {{0.02, -0.01, 0.01}, {0.0, 0.1, 0.0}}, {}};  // at another bias than the node's
}

/// Compares the derivatives of a residual with differences of itself.
template <int kRows, class Residual>
void expectDerivatives(const Residual& residual) {
  const ImuNode i = nodeAt(0.3, {1, 2, 3}), j = nodeAt(0.6, {1.6, 1.9, 3.2});
  const Vector3d gravity(0.4, -0.7, -9.77);
  const ImuResidual<kRows> at = residual(i, j, gravity);
  constexpr double kStep = 1e-6;
  const auto moved = [](ImuNode node, int k, double by) {
    node.apply(by * NodeError::Unit(k));
    return node;
  };
  using Column = Eigen::Matrix<double, kRows, 1>;
  for (int k = 0; k < ImuNode::kSize; ++k) {
    const Column by_i =
        (residual(moved(i, k, kStep), j, gravity).r - residual(moved(i, k, -kStep), j, gravity).r) / (2 * kStep);
    const Column by_j =
        (residual(i, moved(j, k, kStep), gravity).r - residual(i, moved(j, k, -kStep), gravity).r) / (2 * kStep);
    EXPECT_LT((by_i - at.by_i.col(k)).norm(), 1e-6) << "by i, error " << k;
    EXPECT_LT((by_j - at.by_j.col(k)).norm(), 1e-6) << "by j, error " << k;
  }
  for (int k = 0; k < 2; ++k) {
    const Eigen::Vector2d d = kStep * Eigen::Vector2d::Unit(k);
    const Column numeric =
        (residual(i, j, turnedGravity(gravity, d)).r - residual(i, j, turnedGravity(gravity, -d)).r) / (2 * kStep);
    EXPECT_LT((numeric - at.by_gravity.col(k)).norm(), 1e-6) << "by gravity, angle " << k;
  }
}

TEST(ImuFactors, DerivativesAreTheNumericOnes) {
  const ImuPreintegration imu = somewhereElseIntegrated();
  Pose T_measured = poseFromYaw(0.5, {0.5, -0.2, 0.3});
  T_measured.linear() = T_measured.linear() * so3Exp({0.1, 0.2, 0});
  expectDerivatives<9>(
      [&](const ImuNode& i, const ImuNode& j, const Vector3d& g) { return imuResidual(i, j, g, imu); });
  expectDerivatives<6>([](const ImuNode& i, const ImuNode& j, const Vector3d&) { return biasResidual(i, j); });
  expectDerivatives<6>(
      [&](const ImuNode& i, const ImuNode& j, const Vector3d&) { return stepResidual(i, j, T_measured); });
  expectDerivatives<6>([&](const ImuNode&, const ImuNode& j, const Vector3d&) { return poseResidual(j, T_measured); });
  expectDerivatives<3>([](const ImuNode& i, const ImuNode& j, const Vector3d&) { return speedResidual(i, j, 0.13); });
}

TEST(ImuFactors, VanishOnTheMotionThatWasMeasured) {
  const ImuPreintegration imu = somewhereElseIntegrated();
  const Vector3d gravity(0.4, -0.7, -9.77);
  const ImuNode i = nodeAt(0.3, {1, 2, 3});
  ImuNode j = i;
  j.nav = i.nav.after(imu.motion(i.bias), gravity);
  EXPECT_LT(imuResidual(i, j, gravity, imu).r.norm(), 1e-12);
  EXPECT_LT(biasResidual(i, j).r.norm(), 1e-15);
  EXPECT_LT(stepResidual(i, j, i.pose().inverse() * j.pose()).r.norm(), 1e-12);
  EXPECT_LT(poseResidual(j, j.pose()).r.norm(), 1e-12);
}

// ---- the window ----

constexpr double kPeriod = 0.1;

/// An estimator that is driven along the wild drive: perfect readings but for the biases, poses from the truth.
struct Driver {
  test::InertialDrive way = test::wildDrive();
  ImuNoise noise;

  Pose truth(std::size_t k) const { return way.pose(kPeriod * static_cast<double>(k)); }
  std::vector<ImuReading> readings(std::size_t k) const {  // from scan k to the next
    std::vector<ImuReading> readings;
    for (int i = 0; i <= 20; ++i) {
      const double t = 0.005 * i;
      const ImuSample sample = way.reading(kPeriod * static_cast<double>(k) + t);
      readings.push_back({t, sample.gyro_rad_s, sample.accel_m_s2});
    }
    return readings;
  }
  void begin(ImuEstimator& estimator) const {
    estimator.begin(truth(0), way.T_base_imu, {0, 0, -9.81}, Vector3d::Zero(),
                    {.velocity_mps = 0.1, .gravity_rad = 0.01});
  }
  void predict(ImuEstimator& estimator, std::size_t k) const {
    estimator.beginStep();
    estimator.predict(ImuPreintegration(readings(k - 1), estimator.bias(), noise), noise);
  }
  /// Scan k, seen at the truth but for `error`.
  void step(ImuEstimator& estimator, std::size_t k, const Vector6d& error = Vector6d::Zero()) const {
    predict(estimator, k);
    estimator.measurePose(retract(truth(k), error), information());
  }
  static Matrix6d information() {
    return (Vector6d() << 1e4, 1e4, 1e4, 1e6, 1e6, 1e6).finished().asDiagonal();
  }  // 1 cm, 1 mrad
};

TEST(ImuSmoother, FindsTheBiasesOfTheImu) {
  const Driver driver;
  ImuSmoother smoother(5);
  driver.begin(smoother);
  for (std::size_t k = 1; k < 100; ++k) driver.step(smoother, k);
  EXPECT_LT((smoother.bias().gyro - Vector3d(0.002, -0.003, 0.004)).norm(), 5e-4);
  EXPECT_LT((smoother.bias().accel - Vector3d(0.03, -0.02, 0.04)).norm(), 0.02);
  EXPECT_THAT(smoother.basePose(), IsNear(driver.truth(99), 2e-3, 0.02));
  EXPECT_EQ(smoother.nodes(), 5u) << "bounded";
}

TEST(ImuSmoother, WhatLeavesTheWindowIsNotForgotten) {
  const Driver driver;
  ImuSmoother window(3), all(1000);
  driver.begin(window), driver.begin(all);
  std::mt19937 random(3);
  for (std::size_t k = 1; k < 40; ++k) {
    Vector6d error;
    for (int i = 0; i < 6; ++i) error[i] = (i < 3 ? 1e-2 : 1e-3) * (static_cast<double>(random()) / 2147483648.0 - 1);
    driver.step(window, k, error), driver.step(all, k, error);
  }
  ASSERT_EQ(all.nodes(), 40u);
  EXPECT_THAT(window.basePose(), IsNear(all.basePose(), 1e-3, 0.01));
  EXPECT_LT((window.nav().v - all.nav().v).norm(), 5e-3);
  EXPECT_LT((window.bias().gyro - all.bias().gyro).norm(), 1e-4);
  const Matrix6d a = window.stepCovariance(), b = all.stepCovariance();
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(a(i, i), b(i, i), 0.1 * b(i, i)) << i;
}

TEST(ImuSmoother, AWrongMatchIsOutvotedWhereAFilterKeepsIt) {
  const Driver driver;
  ImuSmoother smoother(8);
  ImuFilter filter;
  driver.begin(smoother), driver.begin(filter);
  Vector6d wrong = Vector6d::Zero();
  wrong[0] = 1.0, wrong[5] = 0.2;
  for (std::size_t k = 1; k < 30; ++k) {
    driver.step(smoother, k), driver.step(filter, k);
  }
  driver.step(smoother, 30, wrong), driver.step(filter, 30, wrong);
  EXPECT_GT(local(driver.truth(30), filter.basePose()).head<3>().norm(), 0.5) << "the test must tell";
  EXPECT_THAT(smoother.basePose(), IsNear(driver.truth(30), 0.1, 1.0));
  for (std::size_t k = 31; k < 34; ++k) driver.step(smoother, k);
  EXPECT_THAT(smoother.basePose(), IsNear(driver.truth(33), 0.01, 0.1));
}

TEST(ImuSmoother, GoesOnWithTheImuWhenNothingIsSeen) {
  const Driver driver;
  ImuSmoother smoother(5);
  driver.begin(smoother);
  for (std::size_t k = 1; k < 60; ++k) driver.step(smoother, k);
  for (std::size_t k = 60; k < 80; ++k) driver.predict(smoother, k);
  EXPECT_THAT(smoother.basePose(), IsNear(driver.truth(79), 0.1, 0.3)) << "2 s";
}

TEST(ImuSmoother, KnowsItsVelocityAfterAGapInTheImu) {
  const Driver driver;
  ImuSmoother smoother(5);
  driver.begin(smoother);
  for (std::size_t k = 1; k < 60; ++k) driver.step(smoother, k);
  for (std::size_t k = 60; k < 70; ++k) {
    smoother.beginStep();
    smoother.predictAtSpeed(local(driver.truth(k - 2), driver.truth(k - 1)) / kPeriod, kPeriod);
    smoother.measurePose(driver.truth(k), Driver::information());
    EXPECT_THAT(smoother.basePose(), IsNear(driver.truth(k), 0.01, 0.1)) << k;
  }
  for (std::size_t k = 70; k < 73; ++k) {
    driver.predict(smoother, k);
    EXPECT_THAT(smoother.basePose(), IsNear(driver.truth(k), 0.15, 0.5)) << k << ", by the IMU";
    smoother.measurePose(driver.truth(k), Driver::information());
  }
  EXPECT_THAT(smoother.basePose(), IsNear(driver.truth(72), 0.01, 0.1));
}

TEST(ImuSmoother, AStepThatIsOnlyGuessedGivesWay) {
  ImuSmoother smoother(5);
  smoother.begin(Pose::Identity(), test::tiltedImu(), {0, 0, -9.81}, Vector3d::Zero(), {});
  for (const double x : {20.0, 40.0, 3600.0}) {  // the robot drove on while nobody looked
    smoother.beginStep();
    smoother.predictAtSpeed(Vector6d::Zero(), 0.1);
    const Pose T = poseFromYaw(0.01 * x, {x, 0.3, 0});
    smoother.measurePose(T, Driver::information());
    EXPECT_THAT(smoother.basePose(), IsNear(T, 0.01, 0.05));
  }
}

TEST(ImuSmoother, WheelsHoldTheStepAndABlockedWheelIsRefused) {
  ImuSmoother smoother(5);
  smoother.begin(Pose::Identity(), test::tiltedImu(), {0, 0, -9.81}, Vector3d::Zero(), {});
  const Matrix6d information = 1e4 * Matrix6d::Identity();
  const Vector6d twist = 3 * Vector6d::Unit(0);
  smoother.beginStep();
  smoother.predictAtSpeed(twist, 0.1);
  smoother.measureStep(poseFromYaw(0, {0.34, 0, 0}), information);
  EXPECT_NEAR(smoother.basePose().translation().x(), 0.34, 0.005);
  for (int i = 0; i < 5; ++i) {
    smoother.beginStep();
    smoother.predictAtSpeed(twist, 0.1);
    smoother.measurePose(smoother.basePose(), information);
  }
  smoother.beginStep();
  smoother.predictAtSpeed(twist, 0.1);
  const Pose T_before = smoother.basePose();
  smoother.measureStep(poseFromYaw(0, {-1.5, 0, 0}), information);
  EXPECT_THAT(smoother.basePose(), IsNear(T_before, 1e-9, 1e-9));
}

TEST(ImuSmoother, RestTellsGravityAndGyroBias) {
  ImuSmoother smoother(5);
  smoother.begin(Pose::Identity(), Pose::Identity(), {0, 0, -9.81}, Vector3d::Zero(), {});
  const Vector3d force = 9.81 * Vector3d(0.1, 0, 0.99).normalized(), rate(0.003, -0.002, 0.001);
  smoother.measureRest(force, 0.01, rate, 1e-4);
  EXPECT_LT((smoother.gravity() + force).norm(), 0.15);
  EXPECT_NEAR(smoother.gravity().norm(), 9.81, 1e-9);
  EXPECT_LT((smoother.bias().gyro - rate).norm(), 1e-4);
}

TEST(ImuSmoother, NoSystemIsIllPosed) {
  const Driver driver;
  ImuSmoother smoother(4);
  smoother.begin(Pose::Identity(), test::tiltedImu(), {0, 0, -9.81}, Vector3d::Zero(), {});
  for (std::size_t k = 1; k < 60; ++k) {
    smoother.beginStep();
    if (k % 3 == 0)
      driver.predict(smoother, k);
    else
      smoother.predictAtSpeed(Vector6d::Zero(), k % 3 == 1 ? 0.0 : 3600.0);
    if (k % 7 == 0) smoother.measurePose(smoother.basePose(), Matrix6d::Zero());
    const Matrix6d C = smoother.stepCovariance();
    ASSERT_TRUE(isRigid(smoother.basePose())) << k;
    ASSERT_TRUE(C.allFinite()) << k;
    ASSERT_GT(C.diagonal().minCoeff(), 0) << k;
  }
}

}  // namespace
}  // namespace scslam
