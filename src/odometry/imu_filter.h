// The error-state Kalman filter of an inertial front-end: what is believed about the motion, and how sure.
//
// State: pose and velocity of the IMU in odom, biases, gravity (a direction of known length: the sphere S2), and the
// mounting T_base_imu. Errors: p <- p + dp (odom), R <- R Exp(dtheta), v <- v + dv, gravity turned by two angles,
// T_base_imu as in core/pose.h (Xu et al., "FAST-LIO2", T-RO 2022; He et al., "Kalman filters on differentiable
// manifolds", 2021). The pose of the base as it was reported for the scan before stays in the filter (a stochastic
// clone that is never corrected), so that the covariance of a step is that of the step and not of everything since the
// map began.
#pragma once
#include "scslam/odometry/imu_estimator.h"

namespace scslam {

class ImuFilter : public ImuEstimator {
 public:
  static constexpr int kStates = 23;
  using Covariance = Eigen::Matrix<double, kStates, kStates>;
  using Vector = Eigen::Matrix<double, kStates, 1>;
  using Jacobian6 = Eigen::Matrix<double, 6, kStates>;
  enum Index { kP = 0, kTheta = 3, kV = 6, kGyroBias = 9, kAccelBias = 12, kGravity = 15, kMounting = 17 };

  std::unique_ptr<ImuEstimator> clone() const override { return std::make_unique<ImuFilter>(*this); }
  void begin(const Pose& T_odom_base, const Pose& T_base_imu, const Eigen::Vector3d& gravity,
             const Eigen::Vector3d& velocity, const Start& start) override;

  void beginStep() override;
  void predict(const ImuPreintegration& imu, const ImuNoise& noise) override;
  void predictAtSpeed(const Vector6d& twist, double duration_s) override;

  void measureRest(const Eigen::Vector3d& accel, double accel_sigma, const Eigen::Vector3d& gyro,
                   double gyro_sigma) override;
  /// Beyond 5 sigma it is not taken.
  void measureStep(const Pose& T_previous_base, const Matrix6d& information) override;
  /// The iterated update of the filter, whose search was done outside.
  void measurePose(const Pose& T_odom_base, const Matrix6d& information) override;

  Pose basePose() const override;
  /// Inverse of baseCovariance().
  Matrix6d poseInformation() const override;
  Matrix6d stepCovariance() const override;
  double shareOfStep() const override { return 0.1; }
  NavState nav() const override { return nav_; }
  ImuBias bias() const override { return bias_; }
  Eigen::Vector3d gravity() const override { return gravity_; }
  Pose mounting() const override { return T_base_imu_; }
  void save(ByteWriter& state) const override;
  void load(ByteReader& state) override;

  /// Nothing is known better than 0.1 mm, 0.1 mrad.
  Matrix6d baseCovariance() const;
  const Covariance& covariance() const { return P_; }

  /// Applies an error vector; public for the tests of the Jacobians.
  void apply(const Vector& error);
  /// Derivative of the base pose's tangent by the error.
  Jacobian6 baseJacobian() const;
  /// Derivative of the error after predict() by the error before.
  Covariance transition(const ImuPreintegration& imu) const;

 private:
  Pose baseStep() const { return T_clone_.inverse() * basePose(); }
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
