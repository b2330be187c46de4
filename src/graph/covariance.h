// Covariances of poses along a path of the graph. All are of right perturbations: expressed in the frame a pose leads
// to (core/pose.h).
#pragma once
#include "scslam/graph/pose_graph.h"

namespace scslam {

/// What an information matrix leaves open counts as this much [m^2, rad^2]: beyond any error of a graph.
inline constexpr double kOpenVariance = 1e6;

Matrix6d symmetric(const Matrix6d& M);

/// The inverse, by eigenvalues: directions without information have kOpenVariance.
Matrix6d covarianceOf(const Matrix6d& information);

/// Covariance of T^-1, given that of T.
Matrix6d invertedCovariance(const Matrix6d& covariance, const Pose& T);

/// Squared Mahalanobis length; over (x, y, yaw) when `planar`.
double mahalanobis2(const Vector6d& error, const Matrix6d& covariance, bool planar);

/// A relative pose and how well it is known.
struct UncertainPose {
  Pose T_a_b = Pose::Identity();
  Matrix6d covariance = Matrix6d::Zero();
};
UncertainPose inverted(const UncertainPose& pose);
UncertainPose operator*(const UncertainPose& a, const UncertainPose& b);

/// How far the cycle of two loops with the ways between their ends is from closing, squared Mahalanobis distance:
/// i -> j by loop `one`, j -> l by odometry, l -> k by loop `two` backwards, k -> i by odometry.
double cycleChi2(const UncertainPose& T_i_j, const UncertainPose& T_j_l, const UncertainPose& T_k_l,
                 const UncertainPose& T_k_i, bool planar);

}  // namespace scslam
