#include "scslam/odometry/imu_filter.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "support/support.h"

namespace scslam {
namespace {

using Eigen::Vector3d;
using test::IsNear;
using Index = ImuFilter::Index;

const Vector3d kGravity(0.3, -0.4, -9.79);

ImuFilter aFilter() {
  Pose T_odom_base = poseFromYaw(0.4, {1, 2, 3}), T_base_imu = poseFromYaw(-0.8, {0.3, -0.2, 0.5});
  T_odom_base.linear() = T_odom_base.linear() * so3Exp({0.2, -0.1, 0});
  T_base_imu.linear() = T_base_imu.linear() * so3Exp({0.1, 0.4, 0});
  ImuFilter::Start start;
  start.mounting_m = 0.1, start.mounting_rad = 0.1;
  ImuFilter filter;
  filter.begin(T_odom_base, T_base_imu, kGravity, Vector3d(5, -1, 0.5), start);
  return filter;
}

std::vector<ImuReading> someReadings() {
  std::vector<ImuReading> readings;
  for (int i = 0; i <= 20; ++i) {
    const double t = 0.01 * i;
    readings.push_back({t, {0.5 + t, -0.8 * std::cos(9 * t), 1.2}, {2 * std::sin(7 * t), 1 - 3 * t, 9 + t}});
  }
  return readings;
}

/// The error vector that takes `from` to `to`.
ImuFilter::Vector difference(const ImuFilter& from, const ImuFilter& to) {
  ImuFilter::Vector d = ImuFilter::Vector::Zero();
  d.segment<3>(Index::kP) = to.nav().p - from.nav().p;
  d.segment<3>(Index::kTheta) = so3Log(from.nav().R.transpose() * to.nav().R);
  d.segment<3>(Index::kV) = to.nav().v - from.nav().v;
  d.segment<3>(Index::kGyroBias) = to.bias().gyro - from.bias().gyro;
  d.segment<3>(Index::kAccelBias) = to.bias().accel - from.bias().accel;
  for (int axis = 0; axis < 2; ++axis) {  // by what each angle alone does
    ImuFilter turned = from;
    ImuFilter::Vector step = ImuFilter::Vector::Zero();
    step[Index::kGravity + axis] = 1e-6;
    turned.apply(step);
    const Vector3d direction = (turned.gravity() - from.gravity()) / 1e-6;
    d[Index::kGravity + axis] = direction.dot(to.gravity() - from.gravity()) / direction.squaredNorm();
  }
  d.segment<6>(Index::kMounting) = local(from.mounting(), to.mounting());
  return d;
}

TEST(ImuFilter, TransitionIsTheNumericDerivativeOfThePrediction) {
  const ImuFilter filter = aFilter();
  const ImuPreintegration imu(someReadings(), filter.bias(), {});
  const ImuFilter::Covariance F = filter.transition(imu);
  const auto predicted = [&](const ImuFilter::Vector& error) {
    ImuFilter moved = filter;
    moved.apply(error);
    moved.predict(imu, {});
    return moved;
  };
  const ImuFilter reference = predicted(ImuFilter::Vector::Zero());
  constexpr double kStep = 1e-5;
  for (int i = 0; i < ImuFilter::kStates; ++i) {
    ImuFilter::Vector error = ImuFilter::Vector::Zero();
    error[i] = kStep;
    const ImuFilter::Vector numeric =
        (difference(reference, predicted(error)) - difference(reference, predicted(-error))) / (2 * kStep);
    EXPECT_LT((numeric - F.col(i)).norm(), 1e-5) << "error " << i;
  }
}

TEST(ImuFilter, BaseJacobianIsTheNumericDerivativeOfThePose) {
  const ImuFilter filter = aFilter();
  const ImuFilter::Jacobian6 J = filter.baseJacobian();
  constexpr double kStep = 1e-6;
  for (int i = 0; i < ImuFilter::kStates; ++i) {
    ImuFilter::Vector error = ImuFilter::Vector::Zero();
    error[i] = kStep;
    ImuFilter plus = filter, minus = filter;
    plus.apply(error), minus.apply(-error);
    const Vector6d numeric =
        (local(filter.basePose(), plus.basePose()) - local(filter.basePose(), minus.basePose())) / (2 * kStep);
    EXPECT_LT((numeric - J.col(i)).norm(), 1e-5) << "error " << i;
  }
}

TEST(ImuFilter, GravityKeepsItsLength) {
  ImuFilter filter = aFilter();
  ImuFilter::Vector error = ImuFilter::Vector::Zero();
  error[Index::kGravity] = 0.3, error[Index::kGravity + 1] = -0.2;
  filter.apply(error);
  EXPECT_NEAR(filter.gravity().norm(), kGravity.norm(), 1e-12);
  EXPECT_GT((filter.gravity() - kGravity).norm(), 1);
}

TEST(ImuFilter, APoseTellsTheVelocityItWasReachedWith) {
  ImuFilter filter;
  filter.begin(Pose::Identity(), Pose::Identity(), {0, 0, -9.81}, Vector3d::Zero(), {.gravity_rad = 1e-3});
  std::vector<ImuReading> readings(11);
  for (std::size_t i = 0; i < readings.size(); ++i)
    readings[i].t = 0.01 * static_cast<double>(i), readings[i].accel = {0, 0, 9.81};
  filter.beginStep();
  filter.predict(ImuPreintegration(readings, {}, {}), {});
  filter.measurePose(poseFromYaw(0, {0.7, 0, 0}), 1e6 * Matrix6d::Identity());
  EXPECT_NEAR(filter.nav().v.x(), 7, 0.01);
  EXPECT_THAT(filter.basePose(), IsNear(poseFromYaw(0, {0.7, 0, 0}), 1e-6, 1e-6));
  EXPECT_LT(std::sqrt(filter.covariance()(Index::kV, Index::kV)), 0.1);
}

TEST(ImuFilter, WhatThePoseLeavesOpenKeepsThePrediction) {
  ImuFilter filter;
  filter.begin(Pose::Identity(), Pose::Identity(), {0, 0, -9.81}, Vector3d::Zero(), {});
  filter.beginStep();
  filter.predictAtSpeed(Vector6d::Zero(), 0.1);
  const Matrix6d before = filter.stepCovariance();
  Matrix6d information = 1e6 * Matrix6d::Identity();
  information(0, 0) = 0;  // along the corridor
  Pose T_found = filter.basePose();
  T_found.translation().y() += 0.2;
  filter.measurePose(T_found, information);
  const Matrix6d after = filter.stepCovariance();
  EXPECT_NEAR(after(0, 0), before(0, 0), 1e-3 * before(0, 0));
  EXPECT_LT(after(1, 1), 1.01e-6);
  EXPECT_NEAR(filter.nav().v.y(), 2, 0.1);
  EXPECT_NEAR(filter.nav().v.x(), 0, 1e-9);
}

TEST(ImuFilter, AStepIsAsUncertainAsItselfNotAsAllBeforeIt) {
  ImuFilter filter;
  filter.begin(Pose::Identity(), Pose::Identity(), {0, 0, -9.81}, Vector3d::Zero(),
               {.velocity_mps = 0.1, .gyro_bias = 1e-5, .accel_bias = 1e-3, .gravity_rad = 1e-4});
  std::vector<ImuReading> readings(11);
  for (std::size_t i = 0; i < readings.size(); ++i)
    readings[i].t = 0.01 * static_cast<double>(i), readings[i].accel = {0, 0, 9.81};
  for (int step = 0; step < 50; ++step) {
    filter.beginStep();
    filter.predict(ImuPreintegration(readings, {}, {}), {});
  }
  EXPECT_GT(std::sqrt(filter.baseCovariance()(0, 0)), 0.45) << "5 s at 0.1 m/s";
  EXPECT_LT(std::sqrt(filter.stepCovariance()(0, 0)), 0.1);
}

TEST(ImuFilter, WheelsHoldTheStepAndABlockedWheelIsRefused) {
  ImuFilter filter;
  filter.begin(Pose::Identity(), Pose::Identity(), {0, 0, -9.81}, Vector3d::Zero(), {});
  filter.beginStep();
  Vector6d twist = Vector6d::Zero();
  filter.predictAtSpeed(twist, 0.1);
  Matrix6d information = 1e4 * Matrix6d::Identity();
  filter.measureStep(poseFromYaw(0, {0.3, 0, 0}), information);
  EXPECT_NEAR(filter.basePose().translation().x(), 0.3, 0.01);
  EXPECT_NEAR(filter.nav().v.x(), 3, 0.2);
  for (int i = 0; i < 5; ++i) {
    filter.beginStep();
    filter.predictAtSpeed((Vector6d() << 3, 0, 0, 0, 0, 0).finished(), 0.1);
    filter.measurePose(filter.basePose(), information);
  }
  filter.beginStep();
  filter.predictAtSpeed((Vector6d() << 3, 0, 0, 0, 0, 0).finished(), 0.1);
  const Pose T_before = filter.basePose();
  filter.measureStep(poseFromYaw(0, {-1.5, 0, 0}), information);
  EXPECT_EQ(filter.basePose().matrix(), T_before.matrix());
}

TEST(ImuFilter, RestTellsGravityAndGyroBias) {
  ImuFilter filter;
  filter.begin(Pose::Identity(), Pose::Identity(), {0, 0, -9.81}, Vector3d::Zero(), {});
  const Vector3d force = 9.81 * Vector3d(0.1, 0, 0.99).normalized(), rate(0.003, -0.002, 0.001);
  filter.measureRest(force, 0.01, rate, 1e-4);
  EXPECT_LT((filter.gravity() + force).norm(), 0.15);
  EXPECT_LT((filter.bias().gyro - rate).norm(), 1e-4);
  const ImuFilter::Covariance P = filter.covariance();
  const Eigen::Vector2d tilt_and_bias(P(Index::kGravity, Index::kGravity + 1),
                                      P.block<2, 3>(Index::kGravity, Index::kAccelBias).norm());
  EXPECT_GT(tilt_and_bias[1], 1e-4) << "a tilt and a bias look the same at rest, and the filter knows";
}

}  // namespace
}  // namespace scslam
