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

OdometryPrediction prediction(const std::vector<Keyframe>& keyframes, const std::vector<Pose>& T_map_base,
                              KeyframeId match, KeyframeId query) {
  return {T_map_base[match].inverse() * T_map_base[query], pathCovariance(keyframes, match, query),
          keyframes[query].travelled_m - keyframes[match].travelled_m};
}

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

LoopCloser::LoopCloser(const SlamParams& params, const PluginContext& context, const Pose& T_base_sensor)
    : params_(params.registration),
      names_(params.place.recognisers.names),
      recognisers_(params.place.recognisers.create(context)),
      verifier_(params.registration.method.create(context), params.registration.gates, T_base_sensor.translation()) {}

Descriptor LoopCloser::describe(const Keyframe& keyframe, const Cloud& cloud_base) const {
  const bool described = !recognisers_.empty() && recognisers_.front()->usesScans();
  return described ? recognisers_.front()->describe(keyframe, cloud_base) : Descriptor();
}

void LoopCloser::add(const Keyframe& keyframe, const Descriptor& descriptor, CloudStore& clouds) {
  for (const auto& recogniser : recognisers_) {
    const bool first = recogniser == recognisers_.front();
    const auto cloud = recogniser->usesScans() ? clouds.get(keyframe.id) : std::make_shared<const Cloud>();
    recogniser->add(keyframe, first ? descriptor : Descriptor(), *cloud);
  }
}

std::vector<LoopRecord> LoopCloser::close(KeyframeId query, const std::vector<Keyframe>& keyframes,
                                          const std::vector<Pose>& T_map_base, CloudStore& clouds) {
  target_.reset();
  std::vector<LoopRecord> records;
  for (std::size_t r = 0; r < recognisers_.size(); ++r) {
    recognisers_[r]->setPoses(T_map_base);
    for (const PlaceCandidate& candidate : recognisers_[r]->query(query)) {
      if (registered_.contains({query, candidate.match})) continue;
      const bool closed = std::any_of(records.begin(), records.end(), [&](const LoopRecord& record) {
        return record.match == candidate.match && record.accepted;
      });
      if (!closed) records.push_back(verify(names_[r], candidate, keyframes[query], keyframes, T_map_base, clouds));
    }
  }
  for (const LoopRecord& record : records) restore(record);
  return records;
}

void LoopCloser::restore(const LoopRecord& record) {
  if (record.registered) registered_.emplace(record.query, record.match);
}

LoopRecord LoopCloser::verify(const std::string& recogniser, const PlaceCandidate& candidate, const Keyframe& query,
                              const std::vector<Keyframe>& keyframes, const std::vector<Pose>& T_map_base,
                              CloudStore& clouds) {
  LoopRecord record;
  record.query = query.id, record.match = candidate.match;
  record.recogniser = recogniser;
  record.distance = candidate.distance;
  record.yaw_guess_rad = yawOf(candidate.T_match_query);

  const OdometryPrediction predicted = prediction(keyframes, T_map_base, candidate.match, query.id);
  record.reason = implausible(predicted, params_.gates);
  if (!record.reason.empty()) return record;

  setTarget(candidate.match, query.id, keyframes, T_map_base, clouds);
  fill(record, verifier_.verify(*clouds.get(query.id), {candidate.T_match_query}, predicted, query.planar));
  record.accepted = record.reason.empty();
  if (record.accepted) record.reason = "accepted";
  return record;
}

void LoopCloser::setTarget(KeyframeId match, KeyframeId query, const std::vector<Keyframe>& keyframes,
                           const std::vector<Pose>& T_map_base, CloudStore& clouds) {
  if (target_ == match) return;
  const auto cloud_of = [&clouds](KeyframeId k) { return clouds.get(k); };
  const auto members =
      submapMembers(keyframes, match, query, params_.submap_reach_m, params_.submap_max_each_side);
  LoopTarget target{buildSubmap(members, match, T_map_base, cloud_of), {}, {}};
  for (const KeyframeId k : members) {
    target.T_target_base.push_back(T_map_base[match].inverse() * T_map_base[k]);
    target.clouds.push_back(cloud_of(k));
  }
  verifier_.setTarget(std::move(target));
  target_ = match;
}

}  // namespace scslam
