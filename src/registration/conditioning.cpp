#include "scslam/registration/conditioning.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace scslam {
namespace {

/// Mean of |p|^2 I - p p^T: v^T M v is the mean squared lever of a rotation about v.
Eigen::Matrix3d squaredLevers(const Cloud& source) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < source.size(); ++i) {
    const Eigen::Vector3d p = source.point(i).cast<double>();
    sum += p.squaredNorm() * Eigen::Matrix3d::Identity() - p * p.transpose();
  }
  return sum / static_cast<double>(std::max<std::size_t>(source.size(), 1)) + 1e-6 * Eigen::Matrix3d::Identity();
}

/// Lengths to tangent: translations as they are, rotations by the inverse square root of the squared levers.
Matrix6d toTangent(const Cloud& source, bool inverse) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> levers(squaredLevers(source));
  Matrix6d S = Matrix6d::Identity();
  S.bottomRightCorner<3, 3>() = inverse ? levers.operatorSqrt() : levers.operatorInverseSqrt();
  return S;
}

}  // namespace

Conditioning conditioningOf(const Matrix6d& H, const Cloud& source, double least_share, bool planar) {
  Conditioning result;
  if (source.empty() || !H.allFinite()) return result;
  const Matrix6d S = toTangent(source, false), S_inverse = toTangent(source, true);
  Matrix6d scaled = S * H * S;
  if (planar)
    for (const int axis : {2, 3, 4}) scaled.row(axis).setZero(), scaled.col(axis).setZero();
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(scaled);
  const double least = least_share * H.topLeftCorner<3, 3>().trace();
  Matrix6d fixed = Matrix6d::Zero(), information = Matrix6d::Zero();
  for (int i = 0; i < 6; ++i) {
    const Vector6d v = eigen.eigenvectors().col(i);
    if (eigen.eigenvalues()(i) > least) {
      fixed += v * v.transpose();
      information += eigen.eigenvalues()(i) * v * v.transpose();
    } else {
      ++result.unfixed_axes;
    }
  }
  Matrix6d open = Matrix6d::Identity() - fixed;
  if (planar) {
    result.unfixed_axes -= 3;
    for (const int axis : {2, 3, 4}) open.row(axis).setZero(), open.col(axis).setZero();
  }
  result.unfixed = S * open * S_inverse;
  result.information = S_inverse * information * S_inverse;
  return result;
}

}  // namespace scslam
