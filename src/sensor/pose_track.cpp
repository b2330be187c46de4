#include "scslam/sensor/pose_track.h"

#include <algorithm>
#include <cmath>

namespace scslam {

void PoseTrack::add(Stamp stamp, const Pose& T) {
  if (poses_.empty() || stamp > poses_.back().stamp) poses_.push_back({stamp, T});
}

std::optional<Pose> PoseTrack::at(Stamp stamp) const {
  constexpr double kLongestGap = 5.0, kReach = 0.5;
  if (poses_.empty()) return std::nullopt;
  auto after =
      std::lower_bound(poses_.begin(), poses_.end(), stamp, [](const StampedPose& p, Stamp s) { return p.stamp < s; });
  if (after != poses_.end() && after->stamp == stamp) return after->T;
  const bool outside = after == poses_.begin() || after == poses_.end();
  if (outside) {
    const StampedPose& nearest = after == poses_.end() ? poses_.back() : poses_.front();
    const double away = std::abs(secondsBetween(nearest.stamp, stamp));
    if (away > kReach) return std::nullopt;
    if (poses_.size() < 2) return nearest.T;
    after = after == poses_.end() ? poses_.end() - 1 : poses_.begin() + 1;
  }
  const StampedPose& before = *(after - 1);
  const double gap = secondsBetween(before.stamp, after->stamp);
  if (gap > kLongestGap) return outside ? std::optional((after->stamp < stamp ? after->T : before.T)) : std::nullopt;
  return interpolate(before.T, after->T, secondsBetween(before.stamp, stamp) / gap);
}

bool PoseTrack::covers(Stamp stamp) const {
  if (poses_.empty() || poses_.back().stamp < stamp) return false;
  return poses_.size() > 1 || poses_.back().stamp == stamp;
}

void PoseTrack::forgetBefore(Stamp stamp) {
  while (poses_.size() > 2 && poses_[1].stamp <= stamp) poses_.pop_front();
}

}  // namespace scslam
