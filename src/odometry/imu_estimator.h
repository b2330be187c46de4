// What an inertial front-end believes about its motion: the part in which a filter and a smoother differ.
#pragma once
#include <memory>

#include "scslam/core/bytes.h"
#include "scslam/odometry/imu_preintegration.h"

namespace scslam {

class ImuEstimator {
 public:
  virtual ~ImuEstimator() = default;
  virtual std::unique_ptr<ImuEstimator> clone() const = 0;

  /// One-sigma values at the start.
  struct Start {
    double velocity_mps = 5;
    double gyro_bias = 0.02;   ///< [rad/s]
    double accel_bias = 0.1;   ///< [m/s^2]
    double gravity_rad = 0.5;  ///< direction, before the accelerometer was asked
    double mounting_m = 0;     ///< 0: T_base_imu is taken as exact (a smoother always does)
    double mounting_rad = 0;
  };
  /// In the given pose and motion: position and attitude define odom and are exact, the rest as in `start`.
  /// @param gravity, velocity of the IMU: frame odom.
  virtual void begin(const Pose& T_odom_base, const Pose& T_base_imu, const Eigen::Vector3d& gravity,
                     const Eigen::Vector3d& velocity, const Start& start) = 0;

  // ---- motion ----
  /// From here on the step is counted: call before the prediction.
  virtual void beginStep() = 0;
  virtual void predict(const ImuPreintegration& imu, const ImuNoise& noise) = 0;
  /// Without an IMU: the base goes on at `twist` (v, w, frame base), which may change.
  virtual void predictAtSpeed(const Vector6d& twist, double duration_s) = 0;

  // ---- measurements ----
  /// The mean force and rate over a while without known motion. @param accel_sigma [m/s^2], gyro_sigma [rad/s]; an
  /// infinite one leaves that reading out.
  virtual void measureRest(const Eigen::Vector3d& accel, double accel_sigma, const Eigen::Vector3d& gyro,
                           double gyro_sigma) = 0;
  /// The step since beginStep() was T_previous_base, with this information (tangent, frame base). A step that is beyond
  /// what can be believed (blocked wheels) has little or no effect.
  virtual void measureStep(const Pose& T_previous_base, const Matrix6d& information) = 0;
  /// `T_odom_base` is the most likely pose given basePose(), poseInformation() and measurements of this information
  /// (tangent, frame base; may be singular).
  virtual void measurePose(const Pose& T_odom_base, const Matrix6d& information) = 0;

  // ---- what is believed ----
  virtual Pose basePose() const = 0;
  /// With which a scan match is to hold on to basePose() (tangent, frame base); zero: the match is to stand alone.
  virtual Matrix6d poseInformation() const = 0;
  /// Of the pose since beginStep() (tangent, frame base).
  virtual Matrix6d stepCovariance() const = 0;
  /// Of it, what is left when an IMU compensates the sweeps: the map's errors, for which MatchResult::kCorrelatedPoints
  /// allows, are then nearly the same for two scans in a row. Measured on the simulated scenarios (compare's NEES).
  virtual double shareOfStep() const { return 1.0; }
  virtual NavState nav() const = 0;
  virtual ImuBias bias() const = 0;
  virtual Eigen::Vector3d gravity() const = 0;  ///< frame odom [m/s^2]
  virtual Pose mounting() const = 0;            ///< T_base_imu

  virtual void save(ByteWriter& state) const = 0;
  virtual void load(ByteReader& state) = 0;
};

/// Two directions across gravity (columns) that turn smoothly with it, except straight up: the tangent of its sphere.
Eigen::Matrix<double, 3, 2> acrossGravity(const Eigen::Vector3d& gravity);
/// Gravity turned by two angles [rad] about those directions.
Eigen::Vector3d turnedGravity(const Eigen::Vector3d& gravity, const Eigen::Vector2d& angles);
/// Derivative of turnedGravity() by the angles, at zero.
Eigen::Matrix<double, 3, 2> gravityByAngles(const Eigen::Vector3d& gravity);

}  // namespace scslam
