#include "scslam/pipeline/loop_trial.h"

#include <algorithm>

#include "scslam/core/parallel.h"

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
      reach_m_(params.submap_reach_m),
      max_each_side_(params.submap_max_each_side),
      verifier_(params.method.create(context), params.gates, viewpoint_base) {}

void LoopTrial::setTarget(KeyframeId match, const std::vector<Keyframe>& keyframes, KeyframeId limit,
                          const std::vector<Pose>& T_map_base, const KeyframeCloud& cloud_of) {
  if (target_ == match) return;
  const auto members = submapMembers(keyframes, match, limit, reach_m_, max_each_side_);
  LoopTarget target;
  target.clouds.resize(members.size());
  threads_.forEachChunk(members.size(), 1,
                        [&](std::size_t i, std::size_t, std::size_t) { target.clouds[i] = cloud_of(members[i]); });
  target.submap = buildSubmap(members, match, T_map_base,
                              [&](KeyframeId k) { return target.clouds[k - members.front()]; });  // they are in a row
  for (const KeyframeId k : members) target.T_target_base.push_back(T_map_base[match].inverse() * T_map_base[k]);
  verifier_.setTarget(std::move(target));
  target_ = match;
}

void LoopTrial::verify(LoopRecord& record, const Cloud& query, std::vector<Pose> T_match_query_guesses,
                       const OdometryPrediction& predicted, bool planar) {
  fill(record, verifier_.verify(query, std::move(T_match_query_guesses), predicted, planar));
  record.accepted = record.reason.empty();
  if (record.accepted) record.reason = "accepted";
}

}  // namespace scslam
