#include "scslam/apps/merge/pair_loops.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "scslam/apps/alignment.h"
#include "scslam/pipeline/factors.h"

namespace scslam {
namespace {

constexpr const char* kAlone = "contradicts the loops between the two sessions that agree with each other";

/// refusal() judges all loops of the pair in the end; on the way even one says where to look for more.
ConsistencyParams withoutMinimum(ConsistencyParams params) {
  params.min_across = 1;
  return params;
}

/// No odometry between the sessions: whatever the registration says is plausible.
OdometryPrediction anywhere(const Pose& T_match_query_guess) { return {T_match_query_guess, Matrix6d::Zero(), 1e6}; }

/// Where merged poses put it: about as good as the loops that made them.
OdometryPrediction near(const Pose& T_match_query, double way_to_next_loop_m) {
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(0.3), Eigen::Vector3d::Constant(2 * M_PI / 180);
  return {T_match_query, sigma.cwiseAbs2().asDiagonal(), way_to_next_loop_m};
}

struct TrialOrder {
  std::vector<FoundPlace> places;
  std::size_t stretches = 0;
};

/// Best first within each stretch of the way; then the best of all stretches, the second best of all, …
TrialOrder spreadOut(std::vector<FoundPlace> found, const std::vector<Keyframe>& keyframes, double stretch_m) {
  std::map<std::int64_t, std::vector<FoundPlace>> stretches;
  for (FoundPlace& place : found)
    stretches[static_cast<std::int64_t>(keyframes[place.query].travelled_m / stretch_m)].push_back(std::move(place));
  std::size_t rounds = 0;
  for (auto& [number, places] : stretches) {
    std::stable_sort(places.begin(), places.end(), [](const FoundPlace& p, const FoundPlace& q) {
      return p.candidate.distance < q.candidate.distance;
    });
    rounds = std::max(rounds, places.size());
  }
  TrialOrder order{{}, stretches.size()};
  for (std::size_t round = 0; round < rounds; ++round)
    for (auto& [number, places] : stretches)
      if (round < places.size()) order.places.push_back(std::move(places[round]));
  return order;
}

}  // namespace

PairLoops::PairLoops(const SavedMap& a, const SavedMap& b, const SlamParams& slam, const MergeParams& params)
    : a_(a), b_(b), slam_(slam), params_(params), consistency_(withoutMinimum(slam.graph.consistency)) {
  a.addNodesTo(consistency_);
  b.addNodesTo(consistency_);
}

LoopRecord& PairLoops::attempt(LoopRecord record, const Pose& T_match_query_guess, const OdometryPrediction& predicted,
                               const std::vector<Pose>& T_map_a, LoopTrial& trial) {
  record.yaw_guess_rad = yawOf(T_match_query_guess);
  trial.setTarget(record.match, a_.keyframes(), static_cast<KeyframeId>(a_.keyframes().size()), T_map_a,
                  [this](KeyframeId k) { return a_.cloud(k); });
  const Cloud query = trial.query(record.query, b_.keyframes(), static_cast<KeyframeId>(b_.keyframes().size()),
                                  b_.poses(), [this](KeyframeId k) { return b_.cloud(k); });
  trial.verify(record, query, {T_match_query_guess}, predicted, b_.keyframes()[record.query].planar);
  records_.push_back(std::move(record));
  return records_.back();
}

void PairLoops::tryFound(std::vector<FoundPlace> found, LoopTrial& trial, const std::function<void()>& tick) {
  trial.forgetTarget();
  const TrialOrder order = spreadOut(std::move(found), b_.keyframes(), params_.trial_spacing_m);
  const std::size_t in_vain = static_cast<std::size_t>(params_.rounds_in_vain) * order.stretches;
  for (const FoundPlace& place : order.places) {
    const bool enough = accepted() >= static_cast<std::size_t>(params_.enough_loops) && refusal().empty();
    if (enough || records_.size() >= static_cast<std::size_t>(params_.max_trials)) break;
    if (verified_.empty() && records_.size() >= in_vain) break;
    tick();
    LoopRecord record;
    record.query = place.query, record.match = place.candidate.match;
    record.recogniser = place.recogniser, record.distance = place.candidate.distance;
    LoopRecord& tried = attempt(std::move(record), place.candidate.T_match_query,
                                anywhere(place.candidate.T_match_query), a_.poses(), trial);
    if (tried.accepted && tried.unfixed_axes > 0) {
      tried.accepted = false;
      tried.reason = fmt::format("{} directions unfixed, and no odometry links the sessions", tried.unfixed_axes);
    }
    judge();
  }
}

void PairLoops::tryNear(const std::vector<Pose>& T_map_a, const std::vector<Pose>& T_map_b, LoopTrial& trial,
                        const std::function<void()>& tick) {
  trial.forgetTarget();
  struct Place {
    LoopRecord record;
    double way_m;
  };
  std::vector<Place> places;
  for (KeyframeId j = 0; j < T_map_b.size(); ++j) {
    double best = params_.radius_m * params_.radius_m;
    std::optional<KeyframeId> nearest;
    for (KeyframeId i = 0; i < T_map_a.size(); ++i)
      if (const double d = (T_map_a[i].translation() - T_map_b[j].translation()).squaredNorm(); d <= best)
        best = d, nearest = i;
    if (!nearest) continue;
    LoopRecord record;
    record.query = j, record.match = *nearest, record.recogniser = "radius", record.distance = std::sqrt(best);
    places.push_back({record, distanceToLoops(record)});
  }
  for (int trials = 0; trials < params_.max_loops && !places.empty(); ++trials) {
    const auto farthest = std::max_element(places.begin(), places.end(),
                                           [](const Place& p, const Place& q) { return p.way_m < q.way_m; });
    if (farthest->way_m < params_.loop_distance_m) break;
    tick();
    const Place place = *farthest;
    places.erase(farthest);
    const Pose T_guess = T_map_a[place.record.match].inverse() * T_map_b[place.record.query];
    const LoopRecord& tried = attempt(place.record, T_guess, near(T_guess, place.way_m), T_map_a, trial);
    const bool seen_through =
        tried.free_space_checked && tried.seen_through > slam_.registration.gates.max_seen_through;
    near_accepted_ += tried.accepted ? 1 : 0;
    near_contradicting_ += seen_through ? 1 : 0;
    if (tried.accepted) {
      judge();
      for (Place& other : places) other.way_m = std::min(other.way_m, distanceToLoops(other.record));
    }
  }
}

/// Hands the newest record to the others that passed their gates, and says which of them are believed now.
void PairLoops::judge() {
  LoopRecord& newest = records_.back();
  newest.verified = newest.accepted;
  if (!newest.verified) return;
  Factor factor = loopFactor(newest, slam_.graph);
  factor.j += static_cast<std::uint32_t>(a_.keyframes().size());
  consistency_.addLoop(factor);
  verified_.push_back(records_.size() - 1);
  if (!slam_.graph.consistency.enabled) return;
  for (std::size_t v = 0; v < verified_.size(); ++v) {
    LoopRecord& record = records_[verified_[v]];
    record.accepted = consistency_.believed()[v] != 0;
    record.reason = record.accepted ? "accepted" : kAlone;
  }
}

std::size_t PairLoops::accepted() const {
  return static_cast<std::size_t>(
      std::count_if(records_.begin(), records_.end(), [](const LoopRecord& record) { return record.accepted; }));
}

double PairLoops::distanceToLoops(const LoopRecord& place) const {
  double least = std::numeric_limits<double>::max();
  const auto way = [](const SavedMap& map, KeyframeId k, KeyframeId l) {
    return std::abs(map.keyframes()[k].travelled_m - map.keyframes()[l].travelled_m);
  };
  for (const LoopRecord& record : records_)
    if (record.accepted)
      least = std::min(least, way(a_, place.match, record.match) + way(b_, place.query, record.query));
  return least;
}

double PairLoops::spread() const {
  double low = std::numeric_limits<double>::max(), high = -low;
  for (const LoopRecord& record : records_) {
    if (!record.accepted) continue;
    low = std::min(low, b_.keyframes()[record.query].travelled_m);
    high = std::max(high, b_.keyframes()[record.query].travelled_m);
  }
  return std::max(0.0, high - low);
}

std::string PairLoops::refusal() const {
  const std::size_t believed = accepted();
  if (records_.empty()) return "no place of one looks like a place of the other";
  if (believed < static_cast<std::size_t>(params_.min_loops))
    return fmt::format("{} of {} candidates agree with each other, {} are needed (merge.min_loops)", believed,
                       records_.size(), params_.min_loops);
  if (spread() < params_.min_spread_m)
    return fmt::format("{} loops agree, but within {:.1f} m of way: {:g} m are needed (merge.min_spread_m)", believed,
                       spread(), params_.min_spread_m);
  if (const std::size_t others = verified_.size() - std::min(verified_.size(), believed); others >= believed)
    return fmt::format("ambiguous: {} loops agree with each other, {} contradict them", believed, others);
  const double share = static_cast<double>(near_contradicting_) /
                       static_cast<double>(std::max<std::size_t>(1, near_accepted_ + near_contradicting_));
  if (near_contradicting_ >= 3 && share > params_.max_contradictions)
    return fmt::format("where the loops lay the sessions over each other, {} of {} scans see through the other's walls",
                       near_contradicting_, near_accepted_ + near_contradicting_);
  return "";
}

Pose PairLoops::placement() const {
  std::vector<Pose> in_a, in_b;
  for (const LoopRecord& record : records_) {
    if (!record.accepted) continue;
    in_a.push_back(a_.poses()[record.match] * record.T_match_query);
    in_b.push_back(b_.poses()[record.query]);
  }
  return alignPoses(in_a, in_b, kOrientationLever_m);
}

}  // namespace scslam
