// Residuals of an inertial smoother, with their derivatives.
//
// A node is pose and velocity of the IMU in odom, and its biases; its error has 15 numbers in the order of NodeIndex:
// p <- p + dp (odom), R <- R Exp(dtheta), v <- v + dv, biases + d. Gravity's error are two angles (imu_estimator.h).
#pragma once
#include "scslam/odometry/imu_estimator.h"

namespace scslam {

struct ImuNode {
  static constexpr int kSize = 15;
  enum NodeIndex { kP = 0, kTheta = 3, kV = 6, kGyroBias = 9, kAccelBias = 12 };
  NavState nav;
  ImuBias bias;

  void apply(const Eigen::Matrix<double, kSize, 1>& error);
  Pose pose() const;
};

/// A residual of kRows numbers between two nodes (the later one is `j`) and gravity.
template <int kRows>
struct ImuResidual {
  Eigen::Matrix<double, kRows, 1> r = Eigen::Matrix<double, kRows, 1>::Zero();
  Eigen::Matrix<double, kRows, 2> by_gravity = Eigen::Matrix<double, kRows, 2>::Zero();
  Eigen::Matrix<double, kRows, ImuNode::kSize> by_i = Eigen::Matrix<double, kRows, ImuNode::kSize>::Zero();
  Eigen::Matrix<double, kRows, ImuNode::kSize> by_j = Eigen::Matrix<double, kRows, ImuNode::kSize>::Zero();
};

/// The way from i to j against the preintegrated one: (position, rotation, velocity), in the frame of i. Its covariance
/// is that of the preintegration.
ImuResidual<9> imuResidual(const ImuNode& i, const ImuNode& j, const Eigen::Vector3d& gravity,
                           const ImuPreintegration& imu);
/// Change of the biases (gyro, accel).
ImuResidual<6> biasResidual(const ImuNode& i, const ImuNode& j);
/// The step from i to j against a measured T_i_j: local(T_i_j, T_i^-1 T_j).
ImuResidual<6> stepResidual(const ImuNode& i, const ImuNode& j, const Pose& T_i_j);
/// The velocity of j against the mean one from i to j [m/s], frame odom. @param duration_s > 0.
ImuResidual<3> speedResidual(const ImuNode& i, const ImuNode& j, double duration_s);
/// The pose of j against a measured one: local(T_odom_j, T_j).
ImuResidual<6> poseResidual(const ImuNode& j, const Pose& T_odom_j);

}  // namespace scslam
