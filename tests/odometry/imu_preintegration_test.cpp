#include "scslam/odometry/imu_preintegration.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "sim/imu.h"
#include "support/support.h"

namespace scslam {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A drive with turns, slopes and braking.
sim::Trajectory lively(double duration_s) {
  std::vector<Pose> control;
  Vector3d p = Vector3d::Zero();
  for (int i = 0; i < static_cast<int>(duration_s) + 6; ++i) {
    const double yaw = 0.9 * std::sin(0.7 * i);
    Pose T = poseFromYaw(yaw, p);
    T.linear() = T.linear() * so3Exp({0.15 * std::sin(1.3 * i), 0.1 * std::sin(1.7 * i), 0});
    control.push_back(T);
    p += (8 + 4 * std::sin(0.8 * i)) * Vector3d(std::cos(yaw), std::sin(yaw), 0.08 * std::sin(0.6 * i));
  }
  return {control, 1.0};
}

const Vector3d kGravity(0, 0, -9.81);

std::vector<ImuReading> perfectReadings(const sim::Trajectory& drive, const Pose& T_base_imu, double duration_s,
                                        double rate_hz) {
  std::vector<ImuReading> readings;
  for (int i = 0; i <= static_cast<int>(std::lround(duration_s * rate_hz)); ++i) {
    const double t = i / rate_hz;
    const sim::ImuReading ideal = sim::idealImu(drive.state(t), T_base_imu, 9.81);
    readings.push_back({t, ideal.angular_velocity, ideal.specific_force});
  }
  return readings;
}

NavState truthAt(const sim::Trajectory& drive, const Pose& T_base_imu, double t) {
  const sim::MotionState s = drive.state(t);
  const Pose T = s.T_world_base * T_base_imu;
  const Vector3d lever = s.T_world_base.linear() * s.angular_velocity.cross(T_base_imu.translation());
  return {T.linear(), T.translation(), s.velocity + lever};
}

TEST(ImuPreintegration, APerfectImuIntegratesToTheTruthForTenSeconds) {
  const sim::Trajectory drive = lively(10);
  Pose T_base_imu = poseFromYaw(0.7, {0.4, -0.2, 0.9});
  T_base_imu.linear() = T_base_imu.linear() * so3Exp({0.3, 0.2, 0});
  const ImuPreintegration whole(perfectReadings(drive, T_base_imu, 10, 1000), {}, {});
  const NavState end = truthAt(drive, T_base_imu, 0).after(whole.motion(), kGravity),
                 truth = truthAt(drive, T_base_imu, 10);
  const double way = (truth.p - truthAt(drive, T_base_imu, 0).p).norm();
  ASSERT_GT(way, 40);
  EXPECT_NEAR(whole.motion().duration_s, 10, 1e-9);
  EXPECT_LT((end.p - truth.p).norm() / way, 1e-6);
  EXPECT_LT((end.v - truth.v).norm() / truth.v.norm(), 1e-6);
  EXPECT_LT(so3Log(end.R.transpose() * truth.R).norm(), 1e-6);
}

TEST(ImuPreintegration, HalfTheStepIsAQuarterOfTheError) {
  const sim::Trajectory drive = lively(4);
  const auto error = [&](double rate_hz) {
    const ImuPreintegration whole(perfectReadings(drive, Pose::Identity(), 4, rate_hz), {}, {});
    return (truthAt(drive, Pose::Identity(), 0).after(whole.motion(), kGravity).p -
            truthAt(drive, Pose::Identity(), 4).p)
        .norm();
  };
  EXPECT_NEAR(error(100) / error(200), 4, 0.8) << "what is left is the straight line between two readings";
}

TEST(ImuPreintegration, PartsComposeToTheWhole) {
  const auto readings = perfectReadings(lively(2), Pose::Identity(), 2, 100);
  const std::vector<ImuReading> first(readings.begin(), readings.begin() + 81),
      second(readings.begin() + 80, readings.end());
  const ImuMotion whole = ImuPreintegration(readings, {}, {}).motion(),
                  parts = ImuPreintegration(first, {}, {}).motion().then(ImuPreintegration(second, {}, {}).motion());
  EXPECT_LT((whole.dp - parts.dp).norm(), 1e-10);
  EXPECT_LT((whole.dv - parts.dv).norm(), 1e-10);
  EXPECT_LT((whole.dR - parts.dR).norm(), 1e-10);
}

TEST(ImuPreintegration, JacobiansOfTheBiasesAreTheNumericOnes) {
  const auto readings = perfectReadings(lively(1), Pose::Identity(), 0.5, 100);
  const ImuBias bias{{0.01, -0.02, 0.03}, {0.1, 0.2, -0.1}};
  const ImuPreintegration at(readings, bias, {});
  constexpr double kStep = 1e-5;
  for (int axis = 0; axis < 3; ++axis) {
    const auto motionWith = [&](double gyro, double accel) {
      ImuBias moved = bias;
      moved.gyro[axis] += gyro, moved.accel[axis] += accel;
      return ImuPreintegration(readings, moved, {}).motion();
    };
    const ImuMotion gp = motionWith(kStep, 0), gm = motionWith(-kStep, 0), ap = motionWith(0, kStep),
                    am = motionWith(0, -kStep);
    EXPECT_LT((so3Log(gm.dR.transpose() * gp.dR) / (2 * kStep) - at.dR_dgyro.col(axis)).norm(), 1e-6);
    EXPECT_LT(((gp.dv - gm.dv) / (2 * kStep) - at.dv_dgyro.col(axis)).norm(), 1e-6);
    EXPECT_LT(((gp.dp - gm.dp) / (2 * kStep) - at.dp_dgyro.col(axis)).norm(), 1e-6);
    EXPECT_LT(((ap.dv - am.dv) / (2 * kStep) - at.dv_daccel.col(axis)).norm(), 1e-6);
    EXPECT_LT(((ap.dp - am.dp) / (2 * kStep) - at.dp_daccel.col(axis)).norm(), 1e-6);
  }
}

TEST(ImuPreintegration, AnotherBiasIsTakenIntoAccountToFirstOrder) {
  const auto readings = perfectReadings(lively(1), Pose::Identity(), 0.5, 100);
  const ImuBias other{{0.002, -0.001, 0.003}, {0.02, 0.01, -0.03}};
  const ImuMotion corrected = ImuPreintegration(readings, {}, {}).motion(other),
                  exact = ImuPreintegration(readings, other, {}).motion();
  EXPECT_LT((corrected.dp - exact.dp).norm(), 3e-5);
  EXPECT_LT((corrected.dv - exact.dv).norm(), 3e-5);
  EXPECT_LT(so3Log(corrected.dR.transpose() * exact.dR).norm(), 1e-5);
  EXPECT_GT((exact.dp - ImuPreintegration(readings, {}, {}).motion().dp).norm(), 1e-3) << "the test must tell";
}

TEST(ImuPreintegration, CovarianceIsThatOfManyNoisyRuns) {
  const auto clean = perfectReadings(lively(1), Pose::Identity(), 0.4, 100);
  ImuNoise noise;
  noise.gyro = 0.01, noise.accel = 0.05;
  const ImuPreintegration reference(clean, {}, noise);
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  Matrix9d sum = Matrix9d::Zero();
  constexpr int kRuns = 1500;
  for (int run = 0; run < kRuns; ++run) {
    // Noise of a segment, not of a sample that two segments share: that is what the density states.
    ImuMotion noisy;
    for (std::size_t i = 0; i + 1 < clean.size(); ++i) {
      ImuBias error;
      for (int k = 0; k < 3; ++k) error.gyro[k] = noise.gyro / 0.1 * normal(random);
      for (int k = 0; k < 3; ++k) error.accel[k] = noise.accel / 0.1 * normal(random);
      noisy = noisy.then(motionBetween(clean[i], clean[i + 1], error));
    }
    Eigen::Matrix<double, 9, 1> e;
    e << noisy.dp - reference.motion().dp, so3Log(reference.motion().dR.transpose() * noisy.dR),
        noisy.dv - reference.motion().dv;
    sum += e * e.transpose() / kRuns;
  }
  const Matrix9d L = reference.covariance.llt().matrixL();
  const Matrix9d white = L.inverse() * sum * L.inverse().transpose();
  EXPECT_LT((white - Matrix9d::Identity()).cwiseAbs().maxCoeff(), 0.15);
}

}  // namespace
}  // namespace scslam
