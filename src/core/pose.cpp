#include "scslam/core/pose.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace scslam {

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Matrix3d so3Exp(const Eigen::Vector3d& v) {
  const double angle2 = v.squaredNorm();
  double a, b;  // sin(angle)/angle, (1-cos(angle))/angle^2
  if (angle2 < 1e-12) {
    a = 1 - angle2 / 6;
    b = 0.5 - angle2 / 24;
  } else {
    const double angle = std::sqrt(angle2);
    a = std::sin(angle) / angle;
    b = (1 - std::cos(angle)) / angle2;
  }
  const Eigen::Matrix3d W = skew(v);
  return Eigen::Matrix3d::Identity() + a * W + b * W * W;
}

Eigen::Vector3d so3Log(const Eigen::Matrix3d& R) {
  // Through the quaternion: exact near 0 and near pi.
  Eigen::Quaterniond q(R);
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double s = q.vec().norm();
  if (s < 1e-9) return 2 * q.vec() / q.w();
  return 2 * std::atan2(s, q.w()) / s * q.vec();
}

Eigen::Matrix3d so3RightJacobianInverse(const Eigen::Vector3d& v) {
  const double angle2 = v.squaredNorm();
  double c;  // 1/angle^2 - (1 + cos)/(2 angle sin)
  if (angle2 < 1e-6) {
    c = 1.0 / 12 + angle2 / 720;
  } else {
    const double angle = std::sqrt(angle2);
    c = 1 / angle2 - 0.5 / (angle * std::tan(angle / 2));
  }
  const Eigen::Matrix3d W = skew(v);
  return Eigen::Matrix3d::Identity() + 0.5 * W + c * W * W;
}

Pose retract(const Pose& T, const Vector6d& delta) {
  Pose step = Pose::Identity();
  step.linear() = so3Exp(delta.tail<3>());
  step.translation() = delta.head<3>();
  return T * step;
}

Vector6d local(const Pose& T, const Pose& U) {
  const Pose E = T.inverse() * U;
  Vector6d delta;
  delta << E.translation(), so3Log(E.linear());
  return delta;
}

Matrix6d adjoint(const Pose& T) {
  Matrix6d A = Matrix6d::Zero();
  A.topLeftCorner<3, 3>() = T.linear();
  A.topRightCorner<3, 3>() = skew(T.translation()) * T.linear();
  A.bottomRightCorner<3, 3>() = T.linear();
  return A;
}

Matrix6d composeCovariance(const Matrix6d& cov_a_b, const Pose& T_b_c, const Matrix6d& cov_b_c) {
  const Matrix6d A = adjoint(T_b_c.inverse());
  return A * cov_a_b * A.transpose() + cov_b_c;
}

double levelSigma(const Matrix6d& covariance) { return std::sqrt(std::max(0.0, covariance(0, 0) + covariance(1, 1))); }

double rotationAngle(const Pose& T) { return so3Log(T.linear()).norm(); }

double yawOf(const Pose& T) { return std::atan2(T.linear()(1, 0), T.linear()(0, 0)); }

Pose poseFromYaw(double yaw, const Eigen::Vector3d& t) {
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = t;
  return T;
}

Pose interpolate(const Pose& A, const Pose& B, double u) {
  Pose T = Pose::Identity();
  T.translation() = (1 - u) * A.translation() + u * B.translation();
  T.linear() = A.linear() * so3Exp(u * so3Log(A.linear().transpose() * B.linear()));
  return T;
}

bool isRigid(const Pose& T) {
  if (!T.matrix().allFinite()) return false;
  const Eigen::Matrix3d R = T.linear();
  return (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-3 && R.determinant() > 0;
}

Pose orthonormalised(const Pose& T) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(T.linear(), Eigen::ComputeFullU | Eigen::ComputeFullV);
  Pose result = T;
  Eigen::Matrix3d U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0) U.col(2) = -U.col(2);
  result.linear() = U * svd.matrixV().transpose();
  return result;
}

}  // namespace scslam
