// What a registered loop candidate must show before it may bend the map, in this order.
#pragma once
#include <string>

#include "scslam/core/params.h"
#include "scslam/registration/alignment_quality.h"

namespace scslam {

struct LoopGateParams : ParamSetOf<LoopGateParams> {
  int min_points = 30;
  double max_apart_m = 20;
  double min_explained = 0.45;
  double min_inlier_ratio = 0.85;
  double min_overlap = 0.65;
  double max_rmse_m = 0.15;
  int max_degenerate_axes = 2;
  double max_rival_fit = 0.9;
  double min_target_overlap = 0.85;
  double max_seen_through = 0.05;
  double max_offset_m = 10;
  double odometry_sigma_per_m = 0.01;      ///< trust in odometry for the plausibility gate
  double odometry_sigma_up_per_m = 0.004;  ///< the same for heights: what tells the storeys of a garage apart
  double odometry_sigma_deg_per_m = 0.3;
  double max_odometry_mahalanobis2 = 16.8;  ///< chi2, 6 degrees of freedom, 99 %
  QualityParams quality;
  void describe(ParamVisitor& visitor) override;
};

/// What odometry, loops already closed included, says of a candidate.
struct OdometryPrediction {
  Pose T_match_query = Pose::Identity();
  Matrix6d path_covariance = Matrix6d::Zero();  ///< of it, along the odometry between both, frame query
  double travelled_m = 0;                       ///< length of that path
  bool followed = true;                         ///< odometry lost track nowhere on it (kLostTrack_m)
};

/// How far two overlapping scans agree on what is free: a scan must not see through what the other calls a wall.
struct FreeSpace {
  double target_overlap = 1;  ///< share of the submap's surface in sight of the scan that the scan sees too
  double through_submap = 0;  ///< share of the submap's walls in sight of the scan that it sees through
  double through_scan = 0;    ///< share of the scan's walls in sight of the nearest scan of the submap, likewise
};

/// Why a candidate need not be registered at all: odometry places the query so far from the match that, with the
/// per-metre trust (and, where it lost track, its own uncertainty), it cannot be within max_offset_m of it. Empty
/// when it may be.
std::string implausible(const OdometryPrediction& predicted, const LoopGateParams& params);

/// Why `result` is refused, with the figure ("overlap 0.31 < 0.50"); empty when it passes.
std::string refusal(const RegistrationResult& result, const LoopGateParams& params);
std::string refusal(const FreeSpace& free_space, const LoopGateParams& params);

/// Of the registered pose and its rivals that fit about as well, the one that odometry allows, completed(); when there
/// is not exactly one, the best with the reason in `refusal`.
struct Choice {
  RegistrationResult result;
  double odometry_mahalanobis2 = 0;
  std::string refusal;
};
Choice chosenByOdometry(const RegistrationResult& result, const OdometryPrediction& predicted, bool planar,
                        const LoopGateParams& params);

/// The pose with what the overlap leaves open (RegistrationResult::unfixed) taken from odometry.
Pose completed(const RegistrationResult& result, const OdometryPrediction& predicted);

/// Squared Mahalanobis distance between the measured and the predicted relative pose, given the covariance of the
/// prediction along the path; the covariance is raised to at least the per-metre trust over travelled_m.
/// @param planar x, y and yaw only.
double odometryDisagreement(const Pose& T_match_query_measured, const OdometryPrediction& predicted, bool planar,
                            const LoopGateParams& params);

}  // namespace scslam
