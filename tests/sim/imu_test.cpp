#include "sim/imu.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationIMU.h>

#include "drives.h"
#include "scslam/core/error.h"
#include "scslam/core/mrpt_pose.h"

namespace scslam::sim {
namespace {

using Eigen::Vector3d;
using mrpt::obs::CObservationIMU;
using test::emitted;
using test::start;

Vector3d rates(const CObservationIMU& o) {
  return {o.get(mrpt::obs::IMU_WX), o.get(mrpt::obs::IMU_WY), o.get(mrpt::obs::IMU_WZ)};
}
Vector3d force(const CObservationIMU& o) {
  return {o.get(mrpt::obs::IMU_X_ACC), o.get(mrpt::obs::IMU_Y_ACC), o.get(mrpt::obs::IMU_Z_ACC)};
}

ImuModel perfectAt(double rate_hz) {
  ImuModel model = ImuModel().perfect();
  model.rate_hz = rate_hz;
  return model;
}

TEST(Imu, StandingStillReadsGravityUpAndNoTurn) {
  const Trajectory trajectory = test::parked(10);
  Imu imu(perfectAt(100), trajectory, 1, start());
  const auto readings = emitted<CObservationIMU>(imu);
  ASSERT_EQ(readings.size(), 1001U);
  for (const auto& o : readings) {
    EXPECT_LT((force(*o) - Vector3d(0, 0, 9.81)).norm(), 1e-12);
    EXPECT_LT(rates(*o).norm(), 1e-12);
  }
}

TEST(Imu, StampsFollowTheRateFromTheStart) {
  const Trajectory trajectory = test::parked(10);
  Imu imu(perfectAt(400), trajectory, 1, start());
  const auto readings = emitted<CObservationIMU>(imu);
  ASSERT_EQ(readings.size(), 4001U);
  for (std::size_t k = 0; k < readings.size(); ++k)
    ASSERT_NEAR(secondsBetween(start(), readings[k]->timestamp), static_cast<double>(k) / 400, 1e-7);
}

TEST(Imu, WhiteNoiseHasItsDensityTimesTheRootOfTheRate) {
  const Trajectory trajectory = test::parked(200);
  ImuModel model = perfectAt(100);
  model.gyro_noise = 2e-4, model.accel_noise = 6e-4;
  Imu imu(model, trajectory, 7, start());
  std::array<std::vector<double>, 3> w, f;
  for (const auto& o : emitted<CObservationIMU>(imu))
    for (int axis = 0; axis < 3; ++axis) w[axis].push_back(rates(*o)[axis]), f[axis].push_back(force(*o)[axis]);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_MOMENTS(w[axis], 0, 2e-3);
    EXPECT_MOMENTS(f[axis], axis == 2 ? 9.81 : 0, 6e-3);
  }
}

/// Sigma of the angle that noise alone turns in one second.
double angleAfterOneSecond(double rate_hz) {
  const Trajectory trajectory = test::parked(400);
  ImuModel model = perfectAt(rate_hz);
  model.gyro_noise = 1e-3;
  Imu imu(model, trajectory, 3, start());
  std::vector<double> angles(1);
  std::size_t k = 0;
  for (const auto& o : emitted<CObservationIMU>(imu, 399.999)) {
    if (k > 0 && k % static_cast<std::size_t>(rate_hz) == 0) angles.push_back(0);
    angles.back() += rates(*o).x() / rate_hz;
    ++k;
  }
  return test::momentsOf(angles).sigma;
}

TEST(Imu, AngleRandomWalkDoesNotDependOnTheRate) {
  EXPECT_NEAR(angleAfterOneSecond(100), 1e-3, 3 * 1e-3 / std::sqrt(2.0 * 400));
  EXPECT_NEAR(angleAfterOneSecond(400), 1e-3, 3 * 1e-3 / std::sqrt(2.0 * 400));
}

TEST(Imu, BiasWalksWithTheRootOfTimeAtAnyRate) {
  const Trajectory trajectory = test::parked(4);
  for (double rate : {100.0, 400.0}) {
    ImuModel model = perfectAt(rate);
    model.accel_bias_walk = 1e-3, model.gyro_bias_walk = 1e-4;
    std::vector<double> accel, gyro;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
      Imu imu(model, trajectory, seed, start());
      emitted<CObservationIMU>(imu, 4 - 0.5 / rate);
      for (int axis = 0; axis < 3; ++axis)
        accel.push_back(imu.accel().bias[axis]), gyro.push_back(imu.gyro().bias[axis]);
    }
    EXPECT_MOMENTS(accel, 0, 2e-3);
    EXPECT_MOMENTS(gyro, 0, 2e-4);
  }
}

TEST(Imu, BiasesAreAsSetAndSpreadFromSeedToSeed) {
  const Trajectory trajectory = test::parked(1);
  ImuModel model = perfectAt(100);
  model.gyro_bias = {0.01, -0.02, 0.03}, model.accel_bias = {0.1, 0.2, -0.3};
  Imu exact(model, trajectory, 5, start());
  const auto o = emitted<CObservationIMU>(exact, 0).at(0);
  EXPECT_LT((rates(*o) - Vector3d(0.01, -0.02, 0.03)).norm(), 1e-12);
  EXPECT_LT((force(*o) - Vector3d(0.1, 0.2, 9.51)).norm(), 1e-12);

  model.gyro_bias_sigma = 0.005, model.scale_sigma = 0.01, model.misalignment_sigma_deg = 1;
  std::vector<double> bias, scale, cross;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const Imu imu(model, trajectory, seed, start());
    bias.push_back(imu.gyro().bias.x());
    scale.push_back(imu.accel().matrix(1, 1));
    cross.push_back(imu.accel().matrix(2, 0));
  }
  EXPECT_MOMENTS(bias, 0.01, 0.005);
  EXPECT_MOMENTS(scale, 1, 0.01);
  EXPECT_MOMENTS(cross, 0, M_PI / 180);
}

TEST(Imu, LeverArmOnACircleFollowsTheClosedForm) {
  // Base on a circle of radius R about the point (0, R) of the base frame; the IMU at (a, b): as seen from the centre
  // at (a, b - R), so its acceleration is w' z x (a, b - R) - w^2 (a, b - R).
  const double R = 20, w = 0.5, dw = 0.3, a = 1.2, b = -0.4;
  MotionState motion;
  motion.T_world_base = poseFromYaw(2.1, {5, 6, 7});
  motion.acceleration = motion.T_world_base.linear() * Vector3d(dw * R, w * w * R, 0);
  motion.angular_velocity = {0, 0, w};
  motion.angular_acceleration = {0, 0, dw};
  const ImuReading reading = idealImu(motion, mounting({a, b, 0.7}, {0, 0, 0}, "imu"), 9.81);
  EXPECT_LT((reading.angular_velocity - Vector3d(0, 0, w)).norm(), 1e-12);
  const Vector3d expected(-dw * (b - R) - w * w * a, dw * a - w * w * (b - R), 9.81);
  EXPECT_LT((reading.specific_force - expected).norm(), 1e-12) << reading.specific_force.transpose();
}

TEST(Imu, FieldsAreInTheFrameOfTheSensor) {
  // Turned by 90 deg about the base's x axis: the sensor's y axis points up, its z axis to the right.
  MotionState motion;
  motion.angular_velocity = {0.1, 0.2, 0.3};
  const ImuReading reading = idealImu(motion, mounting({0, 0, 0}, {90, 0, 0}, "imu"), 9.81);
  EXPECT_LT((reading.specific_force - Vector3d(0, 9.81, 0)).norm(), 1e-12);
  EXPECT_LT((reading.angular_velocity - Vector3d(0.1, 0.3, -0.2)).norm(), 1e-12);
}

TEST(Imu, RollPitchAndYawRatesStandInTheirOwnFields) {
  std::vector<Pose> control;
  for (int i = 0; i < 20; ++i) {
    Pose T = Pose::Identity();
    T.linear() = so3Exp(0.1 * i * Vector3d(1, 2, 3));
    control.push_back(T);
  }
  const Trajectory trajectory(control, 1);
  Imu imu(perfectAt(10), trajectory, 1, start());
  for (const auto& o : emitted<CObservationIMU>(imu)) {
    EXPECT_NEAR(o->get(mrpt::obs::IMU_ROLL_VEL), 0.1, 1e-9);
    EXPECT_NEAR(o->get(mrpt::obs::IMU_PITCH_VEL), 0.2, 1e-9);
    EXPECT_NEAR(o->get(mrpt::obs::IMU_YAW_VEL), 0.3, 1e-9);
    EXPECT_FALSE(o->has(mrpt::obs::IMU_YAW));
  }
}

TEST(Imu, IntegratingPerfectReadingsGivesTheDriveBack) {
  const Trajectory trajectory = test::lively();
  ImuModel model = perfectAt(1000);
  model.translation_m = {0.8, -0.3, 1.1}, model.rpy_deg = {10, -20, 130};
  Imu imu(model, trajectory, 1, start());
  const auto readings = emitted<CObservationIMU>(imu);
  ASSERT_EQ(readings.size(), 30001U);

  const Pose T_base_imu = fromMrpt(readings[0]->sensorPose);
  const MotionState first = trajectory.state(0);
  Pose T = first.T_world_base * T_base_imu;
  Vector3d v =
      first.velocity + first.T_world_base.linear() * first.angular_velocity.cross(Vector3d(T_base_imu.translation()));
  const double dt = 1e-3;
  const Vector3d up(0, 0, 9.81);
  for (std::size_t k = 0; k + 1 < readings.size(); ++k) {
    const Vector3d a = T.linear() * force(*readings[k]) - up;
    T.linear() = T.linear() * so3Exp(0.5 * dt * (rates(*readings[k]) + rates(*readings[k + 1])));
    const Vector3d b = T.linear() * force(*readings[k + 1]) - up;
    T.translation() += dt * v + dt * dt / 6 * (2 * a + b);
    v += dt / 2 * (a + b);
  }
  const Pose expected = trajectory.pose(30) * T_base_imu;
  EXPECT_LT((T.translation() - expected.translation()).norm(), 0.01) << "m off after " << trajectory.length() << " m";
  EXPECT_LT(rotationAngle(T.inverse() * expected), 1e-4) << "rad off";
}

TEST(Imu, SameSeedSameReadingsHoweverTheLoopAsks) {
  const Trajectory trajectory = test::lively();
  Imu at_once(ImuModel{}, trajectory, 11, start()), in_steps(ImuModel{}, trajectory, 11, start()),
      other(ImuModel{}, trajectory, 12, start()), second_unit(ImuModel{}, trajectory, 11, start(), 1);
  const auto a = emitted<CObservationIMU>(at_once, 5), c = emitted<CObservationIMU>(other, 5),
             d = emitted<CObservationIMU>(second_unit, 5);
  std::vector<std::shared_ptr<const CObservationIMU>> b;
  for (double t = 0; t <= 5.0001; t += 0.0037)
    for (const auto& o : emitted<CObservationIMU>(in_steps, t)) b.push_back(o);
  ASSERT_EQ(a.size(), 501U);
  ASSERT_GE(b.size(), 500U);
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k) {
    EXPECT_EQ(a[k]->rawMeasurements, b[k]->rawMeasurements);
    EXPECT_EQ(a[k]->timestamp, b[k]->timestamp);
    EXPECT_NE(a[k]->rawMeasurements, c[k]->rawMeasurements);
    EXPECT_NE(a[k]->rawMeasurements, d[k]->rawMeasurements);
  }
  EXPECT_EQ(d[0]->sensorLabel, "imu1");
}

TEST(Imu, IsSilentWhenOffAndAfterTheEnd) {
  const Trajectory trajectory = test::parked(1);
  ImuModel model;
  Imu on(model, trajectory, 1, start());
  EXPECT_EQ(emitted<CObservationIMU>(on).size(), 101U);
  EXPECT_TRUE(emitted<CObservationIMU>(on, 1e12).empty());
  EXPECT_TRUE(std::isinf(on.nextTime()));
  model.enabled = false;
  Imu off(model, trajectory, 1, start());
  EXPECT_TRUE(std::isinf(off.nextTime()));
  EXPECT_TRUE(emitted<CObservationIMU>(off).empty());
}

TEST(Imu, BadMountingIsAUsageErrorThatNamesTheKey) {
  const Trajectory trajectory = test::parked(1);
  ImuModel model;
  model.rpy_deg = {1, 2};
  try {
    Imu imu(model, trajectory, 1, start());
    FAIL() << "no error";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kUsage);
    EXPECT_THAT(e.what(), ::testing::HasSubstr("imu: rpy_deg needs three"));
  }
  ImuModel loaded;
  EXPECT_THROW(loadYaml(loaded, "rate_hz: 0", "test"), Error);
  EXPECT_THROW(loadYaml(loaded, "gyro_nois: 0", "test"), Error);
}

}  // namespace
}  // namespace scslam::sim
