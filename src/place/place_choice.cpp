#include "scslam/place/place_choice.h"

#include <algorithm>
#include <cmath>

#include "scslam/core/gravity.h"

namespace scslam {

void PlaceChoiceParams::describe(ParamVisitor& v) {
  v.field("candidates", candidates, "places handed to the registration at most", 1, 100);
  v.field("max_distance", max_distance, "descriptor distance above which two places do not look alike (0 same .. 1)", 0,
          1);
  v.field("max_ratio", max_ratio,
          "a candidate's distance is at most this share of the runner-up's at a different place; 1: no such test", 0,
          1);
  v.field("min_travel_m", min_travel_m, "a loop needs at least this much path in between [m]", 0, 1e6);
  v.field("distinct_travel_m", distinct_travel_m, "candidates nearer than this along the path count as one place [m]",
          0, 1e4);
}

std::size_t VisitedPlaces::eligibleBefore(KeyframeId k) const {
  const double limit = keyframes_[k].travelled_m - params_.min_travel_m;
  const auto end = keyframes_.begin() + k;
  const auto after = [](double travelled, const Keyframe& keyframe) { return travelled < keyframe.travelled_m; };
  return static_cast<std::size_t>(std::upper_bound(keyframes_.begin(), end, limit, after) - keyframes_.begin());
}

bool VisitedPlaces::samePlace(std::size_t a, std::size_t b) const {
  return std::abs(keyframes_[a].travelled_m - keyframes_[b].travelled_m) < params_.distinct_travel_m;
}

std::vector<PlaceCandidate> VisitedPlaces::choose(std::vector<PlaceCandidate> ranking) const {
  std::sort(ranking.begin(), ranking.end(), [](const PlaceCandidate& a, const PlaceCandidate& b) {
    return std::pair(a.distance, a.match) < std::pair(b.distance, b.match);
  });
  const auto wanted = static_cast<std::size_t>(params_.candidates);
  std::vector<PlaceCandidate> best;  // of each place, one more than wanted: somebody's runner-up
  for (const PlaceCandidate& candidate : ranking) {
    const auto same = [&](const PlaceCandidate& other) { return samePlace(candidate.match, other.match); };
    if (std::any_of(best.begin(), best.end(), same)) continue;
    best.push_back(candidate);
    if (best.size() > wanted) break;
  }
  for (std::size_t i = 0; i < best.size(); ++i)
    best[i].runner_up = i > 0 ? best[0].distance : best.size() > 1 ? best[1].distance : 0;
  if (best.size() > wanted) best.resize(wanted);
  std::erase_if(best, [this](const PlaceCandidate& c) {
    const bool ambiguous = params_.max_ratio < 1 && c.runner_up > 0 && c.distance > params_.max_ratio * c.runner_up;
    return c.distance > params_.max_distance || ambiguous;
  });
  return best;
}

std::vector<PlaceCandidate> VisitedPlaces::inBaseFrames(std::vector<PlaceCandidate> candidates,
                                                        const Keyframe& query) const {
  Pose T_level_query = Pose::Identity(), T_match_level = Pose::Identity();
  T_level_query.linear() = levelling(query.T_odom_base);
  for (PlaceCandidate& candidate : candidates) {
    T_match_level.linear() = levelling(keyframes_[candidate.match].T_odom_base).transpose();
    candidate.T_match_query = T_match_level * candidate.T_match_query * T_level_query;
  }
  return candidates;
}

}  // namespace scslam
