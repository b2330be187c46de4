#include "scslam/keyframe/submap.h"

#include <algorithm>
#include <cmath>

namespace scslam {
namespace {

/// Is it known how this keyframe was reached?
bool followed(const Keyframe& keyframe) { return levelSigma(keyframe.step_covariance) <= kLostTrack_m; }

}  // namespace

std::vector<KeyframeId> submapMembers(const std::vector<Keyframe>& keyframes, KeyframeId centre, KeyframeId limit,
                                      double reach_m, int max_each_side) {
  const auto within = [&](std::size_t k) {
    return std::abs(keyframes[k].travelled_m - keyframes[centre].travelled_m) <= reach_m;
  };
  std::size_t first = centre, last = centre;
  for (int n = 0; n < max_each_side && first > 0 && followed(keyframes[first]) && within(first - 1); ++n) --first;
  for (int n = 0; n < max_each_side && last + 1 < limit && followed(keyframes[last + 1]) && within(last + 1); ++n)
    ++last;
  std::vector<KeyframeId> members;
  for (std::size_t k = first; k <= last; ++k) members.push_back(static_cast<KeyframeId>(k));
  return members;
}

std::vector<Cloud> placedScans(const std::vector<KeyframeId>& members, KeyframeId centre,
                               const std::vector<Pose>& T_map_base, const KeyframeCloud& cloud_of) {
  std::vector<Cloud> placed;
  const Pose T_centre_map = T_map_base[centre].inverse();
  for (const KeyframeId k : members) placed.push_back(transformed(*cloud_of(k), T_centre_map * T_map_base[k]));
  return placed;
}

Cloud joined(const std::vector<Cloud>& clouds) {
  Cloud all;
  for (const Cloud& cloud : clouds) {
    all.x.insert(all.x.end(), cloud.x.begin(), cloud.x.end());
    all.y.insert(all.y.end(), cloud.y.begin(), cloud.y.end());
    all.z.insert(all.z.end(), cloud.z.begin(), cloud.z.end());
  }
  return all;
}

}  // namespace scslam
