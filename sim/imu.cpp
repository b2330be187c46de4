#include "sim/imu.h"

#include <mrpt/obs/CObservationIMU.h>

#include <cmath>

#include "scslam/core/mrpt_pose.h"

namespace scslam::sim {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// What the blocks of one sample are for.
enum Draw : std::uint32_t { kGyroNoise, kAccelNoise, kGyroWalk, kAccelWalk, kUnitBias = 16, kUnitMatrix = 20 };

Imu::Errors drawErrors(const CounterRandom& random, std::uint32_t which, const Vector3d& bias, double bias_sigma,
                       double scale_sigma, double misalignment) {
  Imu::Errors errors;
  errors.bias = bias + bias_sigma * normals(random.block(0, kUnitBias + which));
  for (int row = 0; row < 3; ++row) {
    const Vector3d n = normals(random.block(0, kUnitMatrix + which, static_cast<std::uint32_t>(row)));
    for (int column = 0; column < 3; ++column)
      errors.matrix(row, column) += (row == column ? scale_sigma : misalignment) * n[column];
  }
  return errors;
}

}  // namespace

void ImuModel::describe(ParamVisitor& v) {
  v.field("enabled", enabled, "is there an IMU?");
  v.field("rate_hz", rate_hz, "samples per second", 1, 10000);
  v.field("translation_m", translation_m, "position of the IMU in the base frame: x y z [m]");
  v.field("rpy_deg", rpy_deg, "roll, pitch, yaw of the IMU in the base frame [deg]; R = Rz(yaw) Ry(pitch) Rx(roll)");
  v.field("gravity_mps2", gravity_mps2, "gravity, along -z of the world [m/s^2]", 0, 100);
  v.field("gyro_noise", gyro_noise, "white noise density of the gyroscopes [rad/s/sqrt(Hz)]", 0, 1);
  v.field("accel_noise", accel_noise, "white noise density of the accelerometers [m/s^2/sqrt(Hz)]", 0, 10);
  v.field("gyro_bias_walk", gyro_bias_walk, "random walk density of the gyroscope biases [rad/s^2/sqrt(Hz)]", 0, 1);
  v.field("accel_bias_walk", accel_bias_walk, "random walk density of the accelerometer biases [m/s^3/sqrt(Hz)]", 0,
          10);
  v.field("gyro_bias", gyro_bias, "biases of the gyroscopes at the start: x y z [rad/s]");
  v.field("accel_bias", accel_bias, "biases of the accelerometers at the start: x y z [m/s^2]");
  v.field("gyro_bias_sigma", gyro_bias_sigma, "spread of gyro_bias from seed to seed [rad/s]", 0, 1);
  v.field("accel_bias_sigma", accel_bias_sigma, "spread of accel_bias from seed to seed [m/s^2]", 0, 10);
  v.field("scale_sigma", scale_sigma, "spread of the scale errors from seed to seed, share", 0, 0.5);
  v.field("misalignment_sigma_deg", misalignment_sigma_deg, "spread of the cross-axis angles from seed to seed [deg]",
          0, 10);
}

ImuModel ImuModel::perfect() const {
  ImuModel model = *this;
  model.gyro_noise = model.accel_noise = model.gyro_bias_walk = model.accel_bias_walk = 0;
  model.gyro_bias = model.accel_bias = {0, 0, 0};
  model.gyro_bias_sigma = model.accel_bias_sigma = model.scale_sigma = model.misalignment_sigma_deg = 0;
  return model;
}

ImuReading idealImu(const MotionState& motion, const Pose& T_base_imu, double gravity_mps2) {
  const Vector3d& w = motion.angular_velocity;
  const Vector3d r = T_base_imu.translation();
  const Vector3d lever = motion.angular_acceleration.cross(r) + w.cross(w.cross(r));
  const Vector3d up(0, 0, gravity_mps2);
  const Vector3d force_base = motion.T_world_base.linear().transpose() * (motion.acceleration + up) + lever;
  const Matrix3d R_imu_base = T_base_imu.linear().transpose();
  return {R_imu_base * w, R_imu_base * force_base};
}

Imu::Imu(const ImuModel& model, const Trajectory& trajectory, std::uint64_t seed, Stamp start, std::uint32_t unit)
    : NavigationSensor(trajectory, model.rate_hz, model.enabled, start),
      model_(model),
      T_base_imu_(mounting(model.translation_m, model.rpy_deg, "imu")),
      random_(seed, RandomStream::kImu, unit),
      unit_(unit) {
  const double misalignment = model.misalignment_sigma_deg * M_PI / 180;
  gyro_ = drawErrors(random_, 0, threeOf(model.gyro_bias, "imu", "gyro_bias"), model.gyro_bias_sigma, model.scale_sigma,
                     misalignment);
  accel_ = drawErrors(random_, 1, threeOf(model.accel_bias, "imu", "accel_bias"), model.accel_bias_sigma,
                      model.scale_sigma, misalignment);
}

mrpt::obs::CObservation::Ptr Imu::measure(std::uint32_t index, double t) {
  const double sqrt_dt = std::sqrt(period());
  const auto draw = [&](Draw what) { return normals(random_.block(index, what)); };
  const ImuReading ideal = idealImu(trajectory().state(t), T_base_imu_, model_.gravity_mps2);
  const Vector3d w =
      gyro_.matrix * ideal.angular_velocity + gyro_.bias + model_.gyro_noise / sqrt_dt * draw(kGyroNoise);
  const Vector3d f =
      accel_.matrix * ideal.specific_force + accel_.bias + model_.accel_noise / sqrt_dt * draw(kAccelNoise);
  gyro_.bias += model_.gyro_bias_walk * sqrt_dt * draw(kGyroWalk);
  accel_.bias += model_.accel_bias_walk * sqrt_dt * draw(kAccelWalk);

  auto observation = mrpt::obs::CObservationIMU::Create();
  observation->sensorLabel = unit_ == 0 ? "imu" : "imu" + std::to_string(unit_);
  observation->sensorPose = toMrpt(T_base_imu_);
  // MRPT numbers the rates z, y, x.
  observation->set(mrpt::obs::IMU_WX, w.x());
  observation->set(mrpt::obs::IMU_WY, w.y());
  observation->set(mrpt::obs::IMU_WZ, w.z());
  observation->set(mrpt::obs::IMU_X_ACC, f.x());
  observation->set(mrpt::obs::IMU_Y_ACC, f.y());
  observation->set(mrpt::obs::IMU_Z_ACC, f.z());
  return observation;
}

}  // namespace scslam::sim
