#include "scslam/graph/factor_error.h"

namespace scslam {
namespace {

Pose relativePose(const Factor& factor, const Pose& X_i, const Pose& X_j) {
  return factor.kind == FactorKind::kPrior ? X_j : X_i.inverse() * X_j;
}

Vector6d errorVector(const Pose& E) {
  Vector6d r;
  r << E.translation(), so3Log(E.linear());
  return r;
}

Vector6d positionError(const Factor& factor, const Pose& X_i, const Pose& X_j, Matrix6d* J_i, Matrix6d* J_j) {
  Vector6d r = Vector6d::Zero();
  const Eigen::Vector3d p_i = X_i.inverse() * (X_j * factor.arm);
  r.head<3>() = p_i - factor.T_i_j.translation();
  if (J_i == nullptr) return r;
  const Eigen::Matrix3d R_i_j = X_i.linear().transpose() * X_j.linear();
  J_i->topLeftCorner<3, 3>() = -Eigen::Matrix3d::Identity();
  J_i->topRightCorner<3, 3>() = skew(p_i);
  J_j->topLeftCorner<3, 3>() = R_i_j;
  J_j->topRightCorner<3, 3>() = -R_i_j * skew(factor.arm);
  return r;
}

/// The measured up crossed with what the pose says is up: zero when they agree, blind to the heading.
Vector6d gravityError(const Factor& factor, const Pose& X_j, Matrix6d* J_j) {
  Vector6d r = Vector6d::Zero();
  const Eigen::Vector3d up = X_j.linear().row(2).transpose();
  r.tail<3>() = factor.arm.cross(up);
  if (J_j != nullptr) J_j->bottomRightCorner<3, 3>() = skew(factor.arm) * skew(up);
  return r;
}

}  // namespace

Vector6d factorError(const Factor& factor, const Pose& X_i, const Pose& X_j) {
  if (factor.kind == FactorKind::kPosition) return positionError(factor, X_i, X_j, nullptr, nullptr);
  if (factor.kind == FactorKind::kGravity) return gravityError(factor, X_j, nullptr);
  return errorVector(factor.T_i_j.inverse() * relativePose(factor, X_i, X_j));
}

// With M = X_i^-1 X_j and a step (dt, dr) on the right of X_j: E' = E (dt, dr), hence R_E dt and J_r^-1 dr.
// A step on the right of X_i gives E' = Z^-1 (dt, dr)^-1 M: its rotation is R_E Exp(-R_M^T dr), its translation moves
// by R_Z^T (t_M x dr - dt) to first order.
Vector6d factorError(const Factor& factor, const Pose& X_i, const Pose& X_j, Matrix6d& J_i, Matrix6d& J_j) {
  J_i.setZero();
  J_j.setZero();
  if (factor.kind == FactorKind::kPosition) return positionError(factor, X_i, X_j, &J_i, &J_j);
  if (factor.kind == FactorKind::kGravity) return gravityError(factor, X_j, &J_j);
  const Pose M = relativePose(factor, X_i, X_j);
  const Pose E = factor.T_i_j.inverse() * M;
  const Vector6d r = errorVector(E);
  const Eigen::Matrix3d J_rotation = so3RightJacobianInverse(r.tail<3>());
  J_j.topLeftCorner<3, 3>() = E.linear();
  J_j.bottomRightCorner<3, 3>() = J_rotation;
  if (factor.kind == FactorKind::kPrior) return r;
  const Eigen::Matrix3d R_z_inverse = factor.T_i_j.linear().transpose();
  J_i.topLeftCorner<3, 3>() = -R_z_inverse;
  J_i.topRightCorner<3, 3>() = R_z_inverse * skew(M.translation());
  J_i.bottomRightCorner<3, 3>() = -J_rotation * M.linear().transpose();
  return r;
}

double factorChi2(const PoseGraph& graph, const Factor& factor) {
  const Vector6d r = factorError(factor, graph.poses[factor.i], graph.poses[factor.j]);
  if (!graph.planar) return r.dot(factor.information * r);
  double sum = 0;
  for (const int a : kPlanarAxes)
    for (const int b : kPlanarAxes) sum += r(a) * factor.information(a, b) * r(b);
  return sum;
}

double graphChi2(const PoseGraph& graph) {
  double sum = 0;
  for (const Factor& factor : graph.factors) sum += factorChi2(graph, factor);
  return sum;
}

}  // namespace scslam
