#include "scslam/registration/loop_gates.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace scslam {

void LoopGateParams::describe(ParamVisitor& v) {
  v.field("min_points", min_points, "points the scan must have to be registered: fewer fit many places", 1, 1000000);
  v.field("max_apart_m", max_apart_m,
          "scans taken farther apart than this are no loop: what they share is seen from afar [m]", 0, 1000);
  v.field("min_explained", min_explained, "share of all points of the scan that must lie on a surface of the submap", 0,
          1);
  v.field("min_inlier_ratio", min_inlier_ratio, "the same share among the points that find a surface near them", 0, 1);
  v.field("min_overlap", min_overlap, "share of the scan's points that must lie in space the submap knows", 0, 1);
  v.field("max_rmse_m", max_rmse_m, "of the inliers along the surface normal [m]", 0, 10);
  v.field("max_degenerate_axes", max_degenerate_axes,
          "directions of motion that may stay unfixed; the factor leaves them free", 0, 6);
  v.field("max_rival_fit", max_rival_fit,
          "a different pose that odometry allows too may fit at most this well, relative to the best", 0, 1);
  v.field("min_target_overlap", min_target_overlap,
          "share of the submap's surface in sight of the scan that the scan must see too", 0, 1);
  v.field("max_seen_through", max_seen_through,
          "share of the walls in sight that a scan may see through: of the submap's by the scan, and the reverse", 0,
          1);
  v.field("max_offset_m", max_offset_m, "a place recognised is at most this far away [m]", 0, 1000);
  v.field("odometry_sigma_per_m", odometry_sigma_per_m,
          "a loop may disagree with odometry by this per metre, one sigma [m/m]", 0, 10);
  v.field("odometry_sigma_up_per_m", odometry_sigma_up_per_m, "and in height by this, one sigma [m/m]", 0, 10);
  v.field("odometry_sigma_deg_per_m", odometry_sigma_deg_per_m, "and by this angle per metre, one sigma [deg/m]", 0,
          90);
  v.field("max_odometry_mahalanobis2", max_odometry_mahalanobis2, "chi2 bound of that disagreement", 0, 1e9);
  v.group("quality", quality, "how well the scans are laid on each other, learned from examples");
}

std::string implausible(const OdometryPrediction& predicted, const LoopGateParams& params) {
  const double distance = predicted.T_match_query.translation().norm();
  const double per_metre = params.odometry_sigma_per_m * predicted.travelled_m;
  // Only there: what odometry merely could not fix, along a tunnel say, opens no gate for look-alikes.
  const double sigma = predicted.followed ? per_metre : std::hypot(per_metre, levelSigma(predicted.path_covariance));
  const double limit = params.max_offset_m + std::sqrt(params.max_odometry_mahalanobis2) * sigma;
  if (distance <= limit) return "";
  return fmt::format("odometry places it {:.1f} m away, at most {:.1f} m is plausible", distance, limit);
}

std::string refusal(const RegistrationResult& result, const LoopGateParams& params) {
  if (result.points < static_cast<std::size_t>(params.min_points))
    return fmt::format("{} points < {}", result.points, params.min_points);
  if (!result.converged) return "registration did not converge";
  if (const double apart = result.T_target_source.translation().norm(); apart > params.max_apart_m)
    return fmt::format("{:.1f} m apart > {:.1f} m", apart, params.max_apart_m);
  if (result.overlap < params.min_overlap)
    return fmt::format("overlap {:.2f} < {:.2f}", result.overlap, params.min_overlap);
  if (result.explained < params.min_explained)
    return fmt::format("explained {:.2f} of the scan < {:.2f}", result.explained, params.min_explained);
  if (result.inlier_ratio < params.min_inlier_ratio)
    return fmt::format("inliers {:.2f} < {:.2f}", result.inlier_ratio, params.min_inlier_ratio);
  if (result.rmse_m > params.max_rmse_m)
    return fmt::format("rmse {:.3f} m > {:.3f} m", result.rmse_m, params.max_rmse_m);
  if (result.degenerate_axes > params.max_degenerate_axes)
    return fmt::format("{} directions unfixed > {}", result.degenerate_axes, params.max_degenerate_axes);
  return "";
}

std::string refusal(const FreeSpace& free_space, const LoopGateParams& params) {
  const double limit = params.max_seen_through;
  if (free_space.through_submap > limit)
    return fmt::format("free space: the scan sees through {:.1f} % of the submap's walls > {:.1f} %",
                       100 * free_space.through_submap, 100 * limit);
  if (free_space.through_scan > limit)
    return fmt::format("free space: the submap sees through {:.1f} % of the scan's walls > {:.1f} %",
                       100 * free_space.through_scan, 100 * limit);
  if (free_space.target_overlap < params.min_target_overlap)
    return fmt::format("the scan sees {:.2f} of the submap's surface before it < {:.2f}", free_space.target_overlap,
                       params.min_target_overlap);
  return "";
}

Pose completed(const RegistrationResult& result, const OdometryPrediction& predicted) {
  if (result.degenerate_axes == 0) return result.T_target_source;
  return retract(result.T_target_source, result.unfixed * local(result.T_target_source, predicted.T_match_query));
}

Choice chosenByOdometry(const RegistrationResult& result, const OdometryPrediction& predicted, bool planar,
                        const LoopGateParams& params) {
  const auto judge = [&](RegistrationResult candidate) {
    Choice choice;
    candidate.T_target_source = completed(candidate, predicted);
    choice.odometry_mahalanobis2 = odometryDisagreement(candidate.T_target_source, predicted, planar, params);
    const double distance = candidate.T_target_source.translation().norm();
    if (choice.odometry_mahalanobis2 > params.max_odometry_mahalanobis2)
      choice.refusal = fmt::format("odometry disagrees: chi2 {:.1f} > {:.1f}", choice.odometry_mahalanobis2,
                                   params.max_odometry_mahalanobis2);
    // An unfixed direction is odometry's alone: too far along it, the submap says nothing of the place.
    else if (candidate.degenerate_axes > 0 && distance > params.max_offset_m)
      choice.refusal = fmt::format("{} directions unfixed, and odometry places it {:.1f} m away > {:.1f} m",
                                   candidate.degenerate_axes, distance, params.max_offset_m);
    choice.result = std::move(candidate);
    return choice;
  };
  Choice chosen = judge(result);
  for (const RegistrationResult& rival : result.rivals) {
    if (rival.fit < params.max_rival_fit) continue;
    Choice other = judge(rival);
    if (!other.refusal.empty()) continue;
    if (!chosen.refusal.empty()) {
      chosen = std::move(other);
      continue;
    }
    const Pose difference = chosen.result.T_target_source.inverse() * other.result.T_target_source;
    chosen.refusal =
        fmt::format("ambiguous: a pose {:.1f} m and {:.0f} deg away fits {:.0f} % as well",
                    difference.translation().norm(), rotationAngle(difference) * 180 / M_PI, 100 * rival.fit);
    break;
  }
  return chosen;
}

double odometryDisagreement(const Pose& T_match_query_measured, const OdometryPrediction& predicted, bool planar,
                            const LoopGateParams& params) {
  const Vector6d error = local(predicted.T_match_query, T_match_query_measured);
  const double travelled_m = predicted.travelled_m;
  const double level = params.odometry_sigma_per_m * travelled_m, up = params.odometry_sigma_up_per_m * travelled_m;
  const double turn = params.odometry_sigma_deg_per_m * M_PI / 180 * travelled_m;
  Vector6d variances;
  variances << Eigen::Array3d(level, level, up).square() + 1e-6, Eigen::Array3d::Constant(turn * turn + 1e-8);
  Matrix6d covariance = predicted.path_covariance;
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
