#include "scslam/pipeline/loop_trial.h"

#include <algorithm>

namespace scslam {
namespace {

void fill(LoopRecord& record, const Verification& verification) {
  const RegistrationResult& result = verification.registration;
  record.registered = true;
  record.T_match_query = result.T_target_source;
  record.information = result.hessian;
  record.rmse_m = result.rmse_m, record.inlier_ratio = result.inlier_ratio;
  record.explained = result.explained, record.overlap = result.overlap;
  record.unfixed_axes = result.degenerate_axes;
  record.odometry_mahalanobis2 = verification.odometry_mahalanobis2;
  record.free_space_checked = verification.free_space.has_value();
  if (verification.free_space) {
    record.target_overlap = verification.free_space->target_overlap;
    record.seen_through = std::max(verification.free_space->through_submap, verification.free_space->through_scan);
  }
  record.reason = verification.refusal;
}

}  // namespace

LoopTrial::LoopTrial(const RegistrationParams& params, const PluginContext& context,
                     const Eigen::Vector3d& viewpoint_base)
    : threads_(context.threads),
      params_(params),
      verifier_(params.method.create(context), params.gates, viewpoint_base) {}

void LoopTrial::setTarget(KeyframeId match, const std::vector<Keyframe>& keyframes, KeyframeId limit,
                          const std::vector<Pose>& T_map_base, const KeyframeCloud& cloud_of) {
  if (target_ == match) return;
  verifier_.setTarget(loopTarget(match, keyframes, limit, T_map_base, cloud_of, params_, threads_));
  target_ = match;
}

void LoopTrial::verify(LoopRecord& record, const Cloud& query, std::vector<Pose> T_match_query_guesses,
                       const OdometryPrediction& predicted, bool planar) {
  fill(record, verifier_.verify(query, std::move(T_match_query_guesses), predicted, planar));
  record.accepted = record.reason.empty();
  if (record.accepted) record.reason = "accepted";
}

}  // namespace scslam
