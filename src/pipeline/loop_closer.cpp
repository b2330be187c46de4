#include "scslam/pipeline/loop_closer.h"

#include "scslam/keyframe/submap.h"

namespace scslam {
namespace {

/// Covariance of T_match_query along the odometry chain, frame query.
Matrix6d pathCovariance(const std::vector<Keyframe>& keyframes, KeyframeId match, KeyframeId query) {
  Matrix6d covariance = Matrix6d::Zero();
  for (std::size_t k = match + 1; k <= query; ++k)
    covariance = composeCovariance(covariance, keyframes[k - 1].T_odom_base.inverse() * keyframes[k].T_odom_base,
                                   keyframes[k].step_covariance);
  return covariance;
}

}  // namespace

LoopCloser::LoopCloser(const SlamParams& params, const PluginContext& context)
    : params_(params.registration),
      recogniser_name_(params.place.recogniser.name),
      recogniser_(params.place.recogniser.create(context)),
      registration_(params.registration.method.create(context)) {}

std::vector<LoopRecord> LoopCloser::close(const std::vector<Keyframe>& keyframes, const std::vector<Pose>& T_map_base,
                                          CloudStore& clouds) {
  std::vector<LoopRecord> records;
  for (const PlaceCandidate& candidate : recogniser_->query(keyframes.back().id))
    records.push_back(verify(candidate, keyframes, T_map_base, clouds));
  return records;
}

LoopRecord LoopCloser::verify(const PlaceCandidate& candidate, const std::vector<Keyframe>& keyframes,
                              const std::vector<Pose>& T_map_base, CloudStore& clouds) {
  const Keyframe& query = keyframes.back();
  const Keyframe& match = keyframes[candidate.match];
  LoopRecord record;
  record.query = query.id, record.match = match.id;
  record.recogniser = recogniser_name_;
  record.distance = candidate.distance;
  record.yaw_guess_rad = yawOf(candidate.T_match_query);

  const Pose T_match_query_predicted = T_map_base[match.id].inverse() * T_map_base[query.id];
  const double travelled_m = query.travelled_m - match.travelled_m;
  record.reason = implausible(T_match_query_predicted, travelled_m, params_.gates);
  if (!record.reason.empty()) return record;

  const auto members =
      submapMembers(keyframes, match.id, query.id, params_.submap_reach_m, params_.submap_max_each_side);
  registration_->setTarget(
      buildSubmap(members, match.id, T_map_base, [&clouds](KeyframeId k) { return clouds.get(k); }));
  const RegistrationResult result = registration_->align(*clouds.get(query.id), candidate.T_match_query, query.planar);
  record.registered = true;
  record.T_match_query = result.T_target_source;
  record.information = result.hessian;
  record.rmse_m = result.rmse_m, record.inlier_ratio = result.inlier_ratio, record.overlap = result.overlap;
  record.odometry_mahalanobis2 =
      odometryDisagreement(result.T_target_source, T_match_query_predicted,
                           pathCovariance(keyframes, match.id, query.id), travelled_m, query.planar, params_.gates);

  record.reason = refusal(result, params_.gates);
  if (record.reason.empty() && record.odometry_mahalanobis2 > params_.gates.max_odometry_mahalanobis2)
    record.reason = fmt::format("odometry disagrees: chi2 {:.1f} > {:.1f}", record.odometry_mahalanobis2,
                                params_.gates.max_odometry_mahalanobis2);
  record.accepted = record.reason.empty();
  if (record.accepted) record.reason = "accepted";
  return record;
}

}  // namespace scslam
