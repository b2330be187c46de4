// What the recognisers share: the keyframes so far, which of them may be a loop, and how a ranking becomes candidates.
#pragma once
#include <deque>
#include <vector>

#include "scslam/place/place_recogniser.h"

namespace scslam {

/// Parameters of that choice; a recogniser lists them among its own.
struct PlaceChoiceParams {
  int candidates = 3;
  double max_distance = 0.45;
  double max_ratio = 1;
  double min_travel_m = 15, distinct_travel_m = 10;
  void describe(ParamVisitor& v);
};

class VisitedPlaces {
 public:
  explicit VisitedPlaces(const PlaceChoiceParams& params) : params_(params) {}

  void add(const Keyframe& keyframe) { keyframes_.push_back(keyframe); }
  std::size_t size() const { return keyframes_.size(); }
  const Keyframe& operator[](std::size_t k) const { return keyframes_[k]; }
  /// Keyframes 0 .. n-1 are at least min_travel_m of path before k. @return n
  std::size_t eligibleBefore(KeyframeId k) const;
  /// The best of the ranking, one for each place, with their runners-up.
  /// @param ranking in any order; match, distance and T_match_query filled.
  std::vector<PlaceCandidate> choose(std::vector<PlaceCandidate> ranking) const;
  /// Candidates whose guesses are between the upright frames of match and query: now between their base frames.
  std::vector<PlaceCandidate> inBaseFrames(std::vector<PlaceCandidate> candidates, const Keyframe& query) const;

 private:
  bool samePlace(std::size_t a, std::size_t b) const;

  PlaceChoiceParams params_;
  std::deque<Keyframe> keyframes_;  ///< growing moves nothing
};

}  // namespace scslam
