#include "scslam/pipeline/loop_closer.h"

#include <algorithm>

namespace scslam {

LoopCloser::LoopCloser(const SlamParams& params, const PluginContext& context, const Pose& T_base_sensor)
    : gates_(params.registration.gates),
      names_(params.place.recognisers.names),
      recognisers_(params.place.recognisers.create(context)),
      trial_(params.registration, context, T_base_sensor.translation()) {}

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
  const Matrix6d A = adjoint(keyframe.T_odom_base);
  const Matrix6d step = A * keyframe.step_covariance * A.transpose();
  const int lost = levelSigma(keyframe.step_covariance) > kLostTrack_m ? 1 : 0;
  losses_.push_back(losses_.empty() ? 0 : losses_.back() + lost);
  drift_.push_back(drift_.empty() ? Matrix6d::Zero() : Matrix6d(drift_.back() + step));
}

std::vector<LoopRecord> LoopCloser::close(KeyframeId query, const std::vector<Keyframe>& keyframes,
                                          const std::vector<Pose>& T_map_base, CloudStore& clouds) {
  trial_.forgetTarget();
  query_.reset();
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

OdometryPrediction LoopCloser::predict(const std::vector<Keyframe>& keyframes, const std::vector<Pose>& T_map_base,
                                       KeyframeId match, KeyframeId query) const {
  const Matrix6d A = adjoint(keyframes[query].T_odom_base.inverse());
  return {T_map_base[match].inverse() * T_map_base[query], A * (drift_[query] - drift_[match]) * A.transpose(),
          keyframes[query].travelled_m - keyframes[match].travelled_m, losses_[query] == losses_[match]};
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

  const OdometryPrediction predicted = predict(keyframes, T_map_base, candidate.match, query.id);
  record.reason = implausible(predicted, gates_);
  if (!record.reason.empty()) return record;

  const auto cloud_of = [&clouds](KeyframeId k) { return clouds.get(k); };
  trial_.setTarget(candidate.match, keyframes, query.id, T_map_base, cloud_of);
  if (!query_)
    query_ = trial_.query(query.id, keyframes, static_cast<KeyframeId>(keyframes.size()), T_map_base, cloud_of);
  trial_.verify(record, *query_, {candidate.T_match_query}, predicted, query.planar);
  return record;
}

}  // namespace scslam
