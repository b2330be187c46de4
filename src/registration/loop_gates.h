// What a registered loop candidate must show before it may bend the map, in this order.
#pragma once
#include <string>

#include "scslam/core/params.h"
#include "scslam/registration/registration.h"

namespace scslam {

struct LoopGateParams : ParamSetOf<LoopGateParams> {
  double min_inlier_ratio = 0.92;
  double min_overlap = 0.75;
  double max_rmse_m = 0.15;
  int max_degenerate_axes = 2;
  double max_offset_m = 10;
  double odometry_sigma_per_m = 0.01;      ///< trust in odometry for the plausibility gate
  double odometry_sigma_up_per_m = 0.004;  ///< the same for heights: what tells the storeys of a garage apart
  double odometry_sigma_deg_per_m = 0.3;
  double max_odometry_mahalanobis2 = 16.8;  ///< chi2, 6 degrees of freedom, 99 %
  void describe(ParamVisitor& visitor) override;
};

/// Why a candidate need not be registered at all: odometry places the query so far from the match that, with the
/// per-metre trust, it cannot be within max_offset_m of it. Empty when it may be.
std::string implausible(const Pose& T_match_query_predicted, double travelled_m, const LoopGateParams& params);

/// Why `result` is refused, with the figure ("overlap 0.31 < 0.50"); empty when it passes.
std::string refusal(const RegistrationResult& result, const LoopGateParams& params);

/// Squared Mahalanobis distance between the measured and the predicted relative pose, given the covariance of the
/// prediction along the path; the covariance is raised to at least the per-metre trust over travelled_m.
/// @param planar x, y and yaw only.
double odometryDisagreement(const Pose& T_match_query_measured, const Pose& T_match_query_predicted,
                            const Matrix6d& path_covariance, double travelled_m, bool planar,
                            const LoopGateParams& params);

}  // namespace scslam
