#include "scslam/apps/alignment.h"

#include <Eigen/SVD>
#include <algorithm>

namespace scslam {
namespace {

/// The rotation R that maximises tr(R^T H).
Eigen::Matrix3d rotationOf(const Eigen::Matrix3d& H) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(1, 1, 1);
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign.z() = -1;
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace

Pose alignPoses(const std::vector<Pose>& a, const std::vector<Pose>& b, double lever_m) {
  const std::size_t n = std::min(a.size(), b.size());
  if (n == 0) return Pose::Identity();
  Eigen::Vector3d mean_a = Eigen::Vector3d::Zero(), mean_b = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    mean_a += a[i].translation() / static_cast<double>(n);
    mean_b += b[i].translation() / static_cast<double>(n);
  }
  Eigen::Matrix3d positions = Eigen::Matrix3d::Zero(), orientations = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    positions += (a[i].translation() - mean_a) * (b[i].translation() - mean_b).transpose();
    orientations += a[i].linear() * b[i].linear().transpose();
  }
  // Without a lever nine orders of magnitude below the positions: enough to choose among equally good rotations, too
  // little to bend one.
  const double spread = positions.norm();
  const double weight = spread > 1e-12 ? 1e-9 * spread / static_cast<double>(n) : 1.0;
  if (spread <= 1e-12) positions.setZero();
  Pose T_a_b = Pose::Identity();
  T_a_b.linear() = rotationOf(positions + std::max(weight, 2 * lever_m * lever_m) * orientations);
  T_a_b.translation() = mean_a - T_a_b.linear() * mean_b;
  return T_a_b;
}

}  // namespace scslam
