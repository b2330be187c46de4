#include "scslam/odometry/imu_estimator.h"

namespace scslam {

Eigen::Matrix<double, 3, 2> acrossGravity(const Eigen::Vector3d& gravity) {
  return Eigen::Quaterniond::FromTwoVectors(-Eigen::Vector3d::UnitZ(), gravity).toRotationMatrix().leftCols<2>();
}

Eigen::Vector3d turnedGravity(const Eigen::Vector3d& gravity, const Eigen::Vector2d& angles) {
  return so3Exp(acrossGravity(gravity) * angles) * gravity;
}

Eigen::Matrix<double, 3, 2> gravityByAngles(const Eigen::Vector3d& gravity) {
  return -skew(gravity) * acrossGravity(gravity);
}

}  // namespace scslam
