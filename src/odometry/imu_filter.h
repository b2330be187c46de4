// The error-state Kalman filter of an inertial front-end: what is believed about the motion, and how sure.
//
// State: pose and velocity of the IMU in odom, biases, gravity (a direction of known length: the sphere S2), and the
// mounting T_base_imu. Errors: p <- p + dp (odom), R <- R Exp(dtheta), v <- v + dv, gravity turned by two angles,
// T_base_imu as in core/pose.h (Xu et al., "FAST-LIO2", T-RO 2022; He et al., "Kalman filters on differentiable
// manifolds", 2021). The pose of the base as it was reported for the scan before stays in the filter (a stochastic
// clone that is never corrected), so that the covariance of a step is that of the step and not of everything since the
// map began.
#pragma once
#include "scslam/core/bytes.h"
#include "scslam/odometry/imu_preintegration.h"

namespace scslam {

class ImuFilter {
 public:
  static constexpr int kStates = 23;
  using Covariance = Eigen::Matrix<double, kStates, kStates>;
  using Vector = Eigen::Matrix<double, kStates, 1>;
  using Jacobian6 = Eigen::Matrix<double, 6, kStates>;
  enum Index { kP = 0, kTheta = 3, kV = 6, kGyroBias = 9, kAccelBias = 12, kGravity = 15, kMounting = 17 };

  /// One-sigma values at the start.
  struct Start {
    double velocity_mps = 5;
    double gyro_bias = 0.02;                  ///< [rad/s]
    double accel_bias = 0.1;                  ///< [m/s^2]
    double gravity_rad = 0.5;                 ///< direction, before the accelerometer was asked
    double mounting_m = 0, mounting_rad = 0;  ///< 0: T_base_imu is taken as exact
  };

  /// At rest in the given pose: position and attitude define odom and are exact, the rest as in `start`.
  void begin(const Pose& T_odom_base, const Pose& T_base_imu, const Eigen::Vector3d& gravity, const Start& start);

  // ---- motion ----
  void predict(const ImuPreintegration& imu, const ImuNoise& noise);
  /// Without an IMU: the base goes on at `twist` (v, w, frame base), which may change.
  void predictAtSpeed(const Vector6d& twist, double duration_s);
  /// From here on the step is counted: call before the prediction.
  void cloneBase();

  // ---- measurements ----
  /// The mean force and rate over a while without known motion. @param sigma of the force [m/s^2] and the rate [rad/s];
  /// an infinite one leaves that reading out.
  void measureRest(const Eigen::Vector3d& accel, double accel_sigma, const Eigen::Vector3d& gyro, double gyro_sigma);
  /// The step since cloneBase() was T_previous_base, with this information (tangent, frame base).
  /// @return false when it is beyond 5 sigma and was not taken.
  bool measureStep(const Pose& T_previous_base, const Matrix6d& information);
  /// `T_odom_base` is the most likely pose given basePose(), baseInformation() and measurements of this information
  /// (tangent, frame base; may be singular): the result of an iterated update, whose search was done outside.
  void measurePose(const Pose& T_odom_base, const Matrix6d& information);

  // ---- what is believed ----
  Pose basePose() const;
  Matrix6d baseCovariance() const;
  /// Inverse of baseCovariance(); nothing is known better than 0.1 mm, 0.1 mrad.
  Matrix6d baseInformation() const;
  /// Of the pose since cloneBase().
  Pose baseStep() const { return T_clone_.inverse() * basePose(); }
  Matrix6d stepCovariance() const;
  const NavState& nav() const { return nav_; }
  const ImuBias& bias() const { return bias_; }
  const Eigen::Vector3d& gravity() const { return gravity_; }
  const Pose& mounting() const { return T_base_imu_; }
  const Covariance& covariance() const { return P_; }

  /// Applies an error vector; public for the tests of the Jacobians.
  void apply(const Vector& error);
  /// Derivative of the base pose's tangent by the error.
  Jacobian6 baseJacobian() const;
  /// Derivative of the error after predict() by the error before.
  Covariance transition(const ImuPreintegration& imu) const;

  void save(ByteWriter& state) const;
  void load(ByteReader& state);

 private:
  Eigen::Matrix<double, 3, 2> gravityJacobian() const;
  void propagateCovariance(const Covariance& F, const Covariance& Q);
  /// The update common to all. @param gain_state, gain_clone covariances (state, innovation) and (clone, innovation).
  /// @param W inverse covariance of the innovation.
  void correct(const Eigen::Matrix<double, kStates, 6>& gain_state, const Matrix6d& gain_clone, const Matrix6d& W,
               const Vector6d& innovation);

  NavState nav_;
  ImuBias bias_;
  Eigen::Vector3d gravity_ = Eigen::Vector3d(0, 0, -9.81);
  Pose T_base_imu_ = Pose::Identity();
  Covariance P_ = Covariance::Zero();

  Pose T_clone_ = Pose::Identity();      ///< T_odom_base at the clone
  Matrix6d clone_ = Matrix6d::Zero();    ///< its covariance then
  Jacobian6 cross_ = Jacobian6::Zero();  ///< covariance (clone, state)
};

}  // namespace scslam
