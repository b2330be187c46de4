// The loops between two sessions: tried, judged, and believed together or not at all.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "scslam/apps/merge/merge.h"
#include "scslam/apps/merge/place_search.h"
#include "scslam/pipeline/loop_trial.h"

namespace scslam {

/// Registers a keyframe of b against the surroundings of one of a and judges the result.
class PairLoops {
 public:
  /// @param a, b outlive this.
  PairLoops(const SavedMap& a, const SavedMap& b, const SlamParams& slam, const MergeParams& params);

  /// First round: what the recognisers found, spread over b's way, until enough loops agree with each other.
  /// @param tick called before each trial; may throw to end.
  void tryFound(std::vector<FoundPlace> found, LoopTrial& trial, const std::function<void()>& tick);
  /// Second round: where the poses (one frame) say that b passes a, the places first that are farthest from the loops
  /// so far. With a trust in odometry that grows with the way, the information that a loop adds grows with that
  /// distance alone, so that this is the greedy choice by information gain.
  void tryNear(const std::vector<Pose>& T_map_a, const std::vector<Pose>& T_map_b, LoopTrial& trial,
               const std::function<void()>& tick);

  /// Why the pair is not joined by its loops; empty when it is.
  std::string refusal() const;
  /// All candidates that were registered, with verdicts; match is a's keyframe, query b's.
  const std::vector<LoopRecord>& records() const { return records_; }
  std::vector<LoopRecord>& records() { return records_; }
  std::size_t accepted() const;
  /// T_mapa_mapb by the believed loops, least squares.
  Pose placement() const;

 private:
  LoopRecord& attempt(LoopRecord record, const Pose& T_match_query_guess, const OdometryPrediction& predicted,
                      const std::vector<Pose>& T_map_a, LoopTrial& trial);
  void judge();
  double distanceToLoops(const LoopRecord& place) const;
  double spread() const;

  const SavedMap& a_;
  const SavedMap& b_;
  const SlamParams& slam_;
  const MergeParams& params_;
  LoopConsistency consistency_;
  std::vector<LoopRecord> records_;
  std::vector<std::size_t> verified_;  ///< records_ in the order consistency_ knows them
  std::size_t near_accepted_ = 0, near_contradicting_ = 0;
};

}  // namespace scslam
