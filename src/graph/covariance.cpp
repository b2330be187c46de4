#include "scslam/graph/covariance.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "scslam/graph/factor_error.h"

namespace scslam {

Matrix6d symmetric(const Matrix6d& M) { return 0.5 * (M + M.transpose()); }

Matrix6d covarianceOf(const Matrix6d& information) {
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(symmetric(information));
  const Vector6d variances =
      eigen.eigenvalues().unaryExpr([](double v) { return v > 1 / kOpenVariance ? 1 / v : kOpenVariance; });
  return eigen.eigenvectors() * variances.asDiagonal() * eigen.eigenvectors().transpose();
}

Matrix6d invertedCovariance(const Matrix6d& covariance, const Pose& T) {
  const Matrix6d A = adjoint(T);
  return symmetric(A * covariance * A.transpose());
}

double mahalanobis2(const Vector6d& error, const Matrix6d& covariance, bool planar) {
  if (!planar) return error.dot(covariance.ldlt().solve(error));
  Eigen::Vector3d e;
  Eigen::Matrix3d C;
  for (int r = 0; r < 3; ++r) {
    e(r) = error(kPlanarAxes[r]);
    for (int c = 0; c < 3; ++c) C(r, c) = covariance(kPlanarAxes[r], kPlanarAxes[c]);
  }
  return e.dot(C.ldlt().solve(e));
}

UncertainPose inverted(const UncertainPose& pose) {
  return {pose.T_a_b.inverse(), invertedCovariance(pose.covariance, pose.T_a_b)};
}

UncertainPose operator*(const UncertainPose& a, const UncertainPose& b) {
  return {a.T_a_b * b.T_a_b, symmetric(composeCovariance(a.covariance, b.T_a_b, b.covariance))};
}

double cycleChi2(const UncertainPose& T_i_j, const UncertainPose& T_j_l, const UncertainPose& T_k_l,
                 const UncertainPose& T_k_i, bool planar) {
  const UncertainPose cycle = T_i_j * T_j_l * inverted(T_k_l) * T_k_i;
  return mahalanobis2(local(Pose::Identity(), cycle.T_a_b), cycle.covariance, planar);
}

}  // namespace scslam
