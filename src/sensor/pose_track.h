// Recorded poses of a moving window of time, asked at the stamps of scans.
#pragma once
#include <deque>
#include <optional>

#include "scslam/core/trajectory.h"

namespace scslam {

class PoseTrack {
 public:
  /// Poses come in time order; one that does not is dropped.
  void add(Stamp stamp, const Pose& T);
  /// Pose at `stamp`: interpolated between the poses around it (no farther apart than 5 s); within half a second before
  /// the first or after the last, carried on at the speed there; nullopt elsewhere.
  std::optional<Pose> at(Stamp stamp) const;
  bool empty() const { return poses_.empty(); }
  bool reaches(Stamp stamp) const { return !poses_.empty() && poses_.back().stamp >= stamp; }
  /// Forgets what lies more than one pose before `stamp`.
  void forgetBefore(Stamp stamp);

 private:
  std::deque<StampedPose> poses_;
};

}  // namespace scslam
