// Rigid motions. `T_a_b` maps a point of frame b into frame a: p_a = T_a_b * p_b.
//
// Frames: map (corrected), odom (drifting, smooth), base (robot: x forward, y left, z up), sensor.
// Tangent vectors are (translation, rotation vector) [m, rad] of a right perturbation:
//   retract(T, d) = T * [Exp(d_rot), d_trans],   local(T, U) = (trans, Log(rot)) of T^-1 U,
// so a 6x6 covariance or information of T_a_b is expressed in frame b. This is the error of `optimize` (README).
#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace scslam {

using Pose = Eigen::Isometry3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Rotation vector [rad] to rotation matrix (Rodrigues), exact for small angles.
Eigen::Matrix3d so3Exp(const Eigen::Vector3d& rotation_vector);
/// Rotation matrix to rotation vector [rad], |result| <= pi.
Eigen::Vector3d so3Log(const Eigen::Matrix3d& rotation);
/// Inverse of the right Jacobian of SO(3): Log(Exp(v) Exp(d)) = v + J_r^-1(v) d + o(d).
Eigen::Matrix3d so3RightJacobianInverse(const Eigen::Vector3d& v);
Eigen::Matrix3d skew(const Eigen::Vector3d& v);

Pose retract(const Pose& T, const Vector6d& delta);
Vector6d local(const Pose& T, const Pose& U);

/// Adjoint of this tangent space to first order: T * retract(I, d) = retract(I, adjoint(T) d) * T.
Matrix6d adjoint(const Pose& T);

/// Covariance of T_a_c = T_a_b * T_b_c from independent covariances of both (first order), in frame c.
Matrix6d composeCovariance(const Matrix6d& cov_a_b, const Pose& T_b_c, const Matrix6d& cov_b_c);

/// Sideways and along, one sigma of both together [m].
double levelSigma(const Matrix6d& covariance);
/// A step known no better than this was not followed: odometry lost track and began anew [m].
inline constexpr double kLostTrack_m = 2;

/// Rotation angle of T [rad], in [0, pi].
double rotationAngle(const Pose& T);
/// Heading about z [rad] in (-pi, pi].
double yawOf(const Pose& T);
/// Pose of a yaw about z and a translation.
Pose poseFromYaw(double yaw, const Eigen::Vector3d& t);
/// Pose interpolated between A (u = 0) and B (u = 1): linear translation, geodesic rotation.
Pose interpolate(const Pose& A, const Pose& B, double u);
/// True when all entries are finite and the rotation is orthonormal within 1e-3.
bool isRigid(const Pose& T);
/// The nearest exact rotation (SVD) with the same translation; text files carry few digits.
Pose orthonormalised(const Pose& T);

}  // namespace scslam
