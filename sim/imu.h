// Inertial measurement unit: three gyroscopes and three accelerometers, with the errors of a calibrated MEMS unit.
//
//   measured = (I + E) true + bias(t) + n,   n ~ N(0, density^2 / dt),   bias(t + dt) = bias(t) + N(0, walk^2 dt)
//
// The true acceleration is the specific force at the place of the IMU: lever arm and gravity are in it.
#pragma once
#include "scslam/core/params.h"
#include "sim/navigation_sensor.h"

namespace scslam::sim {

/// Defaults: Xsens MTi-300, the IMU of MulRan (noise densities of its manual). The accelerometer walk is LIO-SAM's.
struct ImuModel : ParamSetOf<ImuModel> {
  bool enabled = true;
  double rate_hz = 100;
  std::vector<double> translation_m = {0, 0, 0};  ///< of T_base_imu
  std::vector<double> rpy_deg = {0, 0, 0};
  double gravity_mps2 = 9.81;
  double gyro_noise = 1.745e-4;                ///< [rad/s/sqrt(Hz)]
  double accel_noise = 5.886e-4;               ///< [m/s^2/sqrt(Hz)]
  double gyro_bias_walk = 1.94e-5;             ///< [rad/s^2/sqrt(Hz)]
  double accel_bias_walk = 6.4e-5;             ///< [m/s^3/sqrt(Hz)]
  std::vector<double> gyro_bias = {0, 0, 0};   ///< at the start [rad/s]
  std::vector<double> accel_bias = {0, 0, 0};  ///< at the start [m/s^2]
  double gyro_bias_sigma = 5e-4;               ///< spread from unit to unit at the start [rad/s]
  double accel_bias_sigma = 0.02;              ///< likewise [m/s^2]
  double scale_sigma = 5e-4;                   ///< spread of the scale errors, share
  double misalignment_sigma_deg = 0.05;        ///< spread of each cross-axis angle

  void describe(ParamVisitor& v) override;
  /// The same unit without any error.
  ImuModel perfect() const;
};

/// In the IMU's frame.
struct ImuReading {
  Eigen::Vector3d angular_velocity;  ///< [rad/s]
  Eigen::Vector3d specific_force;    ///< [m/s^2]; standing still and level: (0, 0, +g)
};

/// What an IMU without errors reads.
ImuReading idealImu(const MotionState& motion, const Pose& T_base_imu, double gravity_mps2);

/// Emits mrpt::obs::CObservationIMU, label "imu": IMU_WX … IMU_WZ and IMU_X_ACC … IMU_Z_ACC in the sensor's own frame,
/// sensorPose T_base_imu.
class Imu : public NavigationSensor {
 public:
  /// @param unit tells several IMUs of one robot apart.
  Imu(const ImuModel& model, const Trajectory& trajectory, std::uint64_t seed, Stamp start, std::uint32_t unit = 0);

  /// What a calibration would have to find.
  struct Errors {
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();  ///< I + E
    Eigen::Vector3d bias = Eigen::Vector3d::Zero();        ///< now
  };
  const Errors& gyro() const { return gyro_; }
  const Errors& accel() const { return accel_; }

 private:
  mrpt::obs::CObservation::Ptr measure(std::uint32_t index, double t) override;

  ImuModel model_;
  Pose T_base_imu_;
  CounterRandom random_;
  std::uint32_t unit_;
  Errors gyro_, accel_;
};

}  // namespace scslam::sim
