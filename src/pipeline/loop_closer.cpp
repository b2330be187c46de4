#include "scslam/pipeline/loop_closer.h"

#include <algorithm>

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
      names_(params.place.recognisers.names),
      recognisers_(params.place.recognisers.create(context)),
      registration_(params.registration.method.create(context)) {}

Descriptor LoopCloser::describe(const Keyframe& keyframe, const Cloud& cloud_base) const {
  const bool described = !recognisers_.empty() && recognisers_.front()->usesScans();
  return described ? recognisers_.front()->describe(keyframe, cloud_base) : Descriptor();
}

void LoopCloser::add(const Keyframe& keyframe, const Descriptor& descriptor, CloudStore& clouds) {
  for (const auto& recogniser : recognisers_) {
    const bool first = recogniser == recognisers_.front();
    if (first || !recogniser->usesScans())
      recogniser->add(keyframe, first ? descriptor : Descriptor());
    else
      recogniser->add(keyframe, recogniser->describe(keyframe, *clouds.get(keyframe.id)));
  }
}

std::vector<LoopRecord> LoopCloser::close(const std::vector<Keyframe>& keyframes, const std::vector<Pose>& T_map_base,
                                          CloudStore& clouds) {
  std::vector<LoopRecord> records;
  for (std::size_t r = 0; r < recognisers_.size(); ++r) {
    recognisers_[r]->setPoses(T_map_base);
    for (const PlaceCandidate& candidate : recognisers_[r]->query(keyframes.back().id)) {
      const bool closed = std::any_of(records.begin(), records.end(), [&](const LoopRecord& record) {
        return record.match == candidate.match && record.accepted;
      });
      if (!closed) records.push_back(verify(names_[r], candidate, keyframes, T_map_base, clouds));
    }
  }
  return records;
}

LoopRecord LoopCloser::verify(const std::string& recogniser, const PlaceCandidate& candidate,
                              const std::vector<Keyframe>& keyframes, const std::vector<Pose>& T_map_base,
                              CloudStore& clouds) {
  const Keyframe& query = keyframes.back();
  const Keyframe& match = keyframes[candidate.match];
  LoopRecord record;
  record.query = query.id, record.match = match.id;
  record.recogniser = recogniser;
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
