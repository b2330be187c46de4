#include "scslam/odometry/imu_factors.h"

namespace scslam {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void ImuNode::apply(const Eigen::Matrix<double, kSize, 1>& error) {
  nav.p += error.segment<3>(kP);
  nav.R = Eigen::Quaterniond(nav.R * so3Exp(error.segment<3>(kTheta))).normalized().toRotationMatrix();
  nav.v += error.segment<3>(kV);
  bias.gyro += error.segment<3>(kGyroBias);
  bias.accel += error.segment<3>(kAccelBias);
}

Pose ImuNode::pose() const {
  Pose T = Pose::Identity();
  T.linear() = nav.R;
  T.translation() = nav.p;
  return T;
}

ImuResidual<9> imuResidual(const ImuNode& i, const ImuNode& j, const Vector3d& gravity, const ImuPreintegration& imu) {
  using N = ImuNode;
  const ImuMotion m = imu.motion(i.bias);
  const double T = m.duration_s;
  const Matrix3d R_i_odom = i.nav.R.transpose();
  const Vector3d way = R_i_odom * (j.nav.p - i.nav.p - T * i.nav.v - 0.5 * T * T * gravity);
  const Vector3d change = R_i_odom * (j.nav.v - i.nav.v - T * gravity);
  const Vector3d turn = so3Log(m.dR.transpose() * R_i_odom * j.nav.R);
  const Matrix3d J = so3RightJacobianInverse(turn);
  const Eigen::Matrix<double, 3, 2> B = gravityByAngles(gravity);

  ImuResidual<9> res;
  res.r << way - m.dp, turn, change - m.dv;
  res.by_i.block<3, 3>(0, N::kP) = -R_i_odom;
  res.by_i.block<3, 3>(0, N::kTheta) = skew(way);
  res.by_i.block<3, 3>(0, N::kV) = -T * R_i_odom;
  res.by_i.block<3, 3>(0, N::kGyroBias) = -imu.dp_dgyro;
  res.by_i.block<3, 3>(0, N::kAccelBias) = -imu.dp_daccel;
  res.by_gravity.topRows<3>() = -0.5 * T * T * R_i_odom * B;
  res.by_j.block<3, 3>(0, N::kP) = R_i_odom;

  res.by_i.block<3, 3>(3, N::kTheta) = -J * j.nav.R.transpose() * i.nav.R;
  // The bias enters dR to first order at the bias it was integrated with: dR Exp(J (b - b0)).
  const Vector3d by_bias = imu.dR_dgyro * (i.bias.gyro - imu.bias().gyro);
  const Matrix3d right_jacobian = so3RightJacobianInverse(by_bias).inverse();
  res.by_i.block<3, 3>(3, N::kGyroBias) = -J * so3Exp(-turn) * right_jacobian * imu.dR_dgyro;
  res.by_j.block<3, 3>(3, N::kTheta) = J;

  res.by_i.block<3, 3>(6, N::kTheta) = skew(change);
  res.by_i.block<3, 3>(6, N::kV) = -R_i_odom;
  res.by_i.block<3, 3>(6, N::kGyroBias) = -imu.dv_dgyro;
  res.by_i.block<3, 3>(6, N::kAccelBias) = -imu.dv_daccel;
  res.by_gravity.bottomRows<3>() = -T * R_i_odom * B;
  res.by_j.block<3, 3>(6, N::kV) = R_i_odom;
  return res;
}

ImuResidual<6> biasResidual(const ImuNode& i, const ImuNode& j) {
  ImuResidual<6> res;
  res.r << j.bias.gyro - i.bias.gyro, j.bias.accel - i.bias.accel;
  res.by_i.rightCols<6>() = -Matrix6d::Identity();
  res.by_j.rightCols<6>() = Matrix6d::Identity();
  return res;
}

ImuResidual<6> stepResidual(const ImuNode& i, const ImuNode& j, const Pose& T_i_j) {
  using N = ImuNode;
  const Pose T = i.pose().inverse() * j.pose();
  const Matrix3d R_measured = T_i_j.linear().transpose(), R_i_odom = i.nav.R.transpose();
  ImuResidual<6> res;
  res.r = local(T_i_j, T);
  const Matrix3d J = so3RightJacobianInverse(res.r.tail<3>());
  res.by_i.block<3, 3>(0, N::kP) = -R_measured * R_i_odom;
  res.by_i.block<3, 3>(0, N::kTheta) = R_measured * skew(T.translation());
  res.by_i.block<3, 3>(3, N::kTheta) = -J * T.linear().transpose();
  res.by_j.block<3, 3>(0, N::kP) = R_measured * R_i_odom;
  res.by_j.block<3, 3>(3, N::kTheta) = J;
  return res;
}

ImuResidual<3> speedResidual(const ImuNode& i, const ImuNode& j, double duration_s) {
  ImuResidual<3> res;
  res.r = j.nav.v - (j.nav.p - i.nav.p) / duration_s;
  res.by_i.block<3, 3>(0, ImuNode::kP) = Matrix3d::Identity() / duration_s;
  res.by_j.block<3, 3>(0, ImuNode::kP) = -Matrix3d::Identity() / duration_s;
  res.by_j.block<3, 3>(0, ImuNode::kV) = Matrix3d::Identity();
  return res;
}

ImuResidual<6> poseResidual(const ImuNode& j, const Pose& T_odom_j) {
  ImuResidual<6> res;
  res.r = local(T_odom_j, j.pose());
  res.by_j.block<3, 3>(0, ImuNode::kP) = T_odom_j.linear().transpose();
  res.by_j.block<3, 3>(3, ImuNode::kTheta) = so3RightJacobianInverse(res.r.tail<3>());
  return res;
}

}  // namespace scslam
