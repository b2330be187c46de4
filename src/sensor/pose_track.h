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
  /// Will poses that are still to come not change at(stamp)?
  bool covers(Stamp stamp) const;
  /// Forgets what lies more than one pose before `stamp`.
  void forgetBefore(Stamp stamp);

 private:
  std::deque<StampedPose> poses_;
};

}  // namespace scslam
