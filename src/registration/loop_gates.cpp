#include "scslam/registration/loop_gates.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace scslam {

void LoopGateParams::describe(ParamVisitor& v) {
  v.field("min_inlier_ratio", min_inlier_ratio, "share of the scan's points that must lie on a surface of the submap",
          0, 1);
  v.field("min_overlap", min_overlap, "share of the scan's points that must lie in space the submap knows", 0, 1);
  v.field("max_rmse_m", max_rmse_m, "of the inliers along the surface normal [m]", 0, 10);
  v.field("max_degenerate_axes", max_degenerate_axes, "directions of motion that may stay unfixed", 0, 6);
  v.field("max_offset_m", max_offset_m, "a place recognised is at most this far away [m]", 0, 1000);
  v.field("odometry_sigma_per_m", odometry_sigma_per_m,
          "a loop may disagree with odometry by this per metre, one sigma [m/m]", 0, 10);
  v.field("odometry_sigma_up_per_m", odometry_sigma_up_per_m, "and in height by this, one sigma [m/m]", 0, 10);
  v.field("odometry_sigma_deg_per_m", odometry_sigma_deg_per_m, "and by this angle per metre, one sigma [deg/m]", 0,
          90);
  v.field("max_odometry_mahalanobis2", max_odometry_mahalanobis2, "chi2 bound of that disagreement", 0, 1e9);
}

std::string implausible(const Pose& T_match_query_predicted, double travelled_m, const LoopGateParams& params) {
  const double distance = T_match_query_predicted.translation().norm();
  const double sigma = params.odometry_sigma_per_m * travelled_m;
  const double limit = params.max_offset_m + std::sqrt(params.max_odometry_mahalanobis2) * sigma;
  if (distance <= limit) return "";
  return fmt::format("odometry places it {:.1f} m away, at most {:.1f} m is plausible", distance, limit);
}

std::string refusal(const RegistrationResult& result, const LoopGateParams& params) {
  if (!result.converged) return "registration did not converge";
  if (result.overlap < params.min_overlap)
    return fmt::format("overlap {:.2f} < {:.2f}", result.overlap, params.min_overlap);
  if (result.inlier_ratio < params.min_inlier_ratio)
    return fmt::format("inliers {:.2f} < {:.2f}", result.inlier_ratio, params.min_inlier_ratio);
  if (result.rmse_m > params.max_rmse_m)
    return fmt::format("rmse {:.3f} m > {:.3f} m", result.rmse_m, params.max_rmse_m);
  if (result.degenerate_axes > params.max_degenerate_axes)
    return fmt::format("{} directions unfixed > {}", result.degenerate_axes, params.max_degenerate_axes);
  return "";
}

double odometryDisagreement(const Pose& T_match_query_measured, const Pose& T_match_query_predicted,
                            const Matrix6d& path_covariance, double travelled_m, bool planar,
                            const LoopGateParams& params) {
  const Vector6d error = local(T_match_query_predicted, T_match_query_measured);
  const double level = params.odometry_sigma_per_m * travelled_m, up = params.odometry_sigma_up_per_m * travelled_m;
  const double turn = params.odometry_sigma_deg_per_m * M_PI / 180 * travelled_m;
  Vector6d variances;
  variances << Eigen::Array3d(level, level, up).square() + 1e-6, Eigen::Array3d::Constant(turn * turn + 1e-8);
  Matrix6d covariance = path_covariance;
  covariance.diagonal() += variances;
  if (!planar) return error.dot(covariance.ldlt().solve(error));
  const int axes[3] = {0, 1, 5};
  Eigen::Matrix3d C;
  Eigen::Vector3d e;
  for (int r = 0; r < 3; ++r) {
    e(r) = error(axes[r]);
    for (int c = 0; c < 3; ++c) C(r, c) = covariance(axes[r], axes[c]);
  }
  return e.dot(C.ldlt().solve(e));
}

}  // namespace scslam
