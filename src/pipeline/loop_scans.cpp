#include "scslam/pipeline/loop_scans.h"

#include <algorithm>

#include "scslam/core/voxel_filter.h"
#include "scslam/keyframe/steady_points.h"

namespace scslam {
namespace {

/// At the ends of a drive there are fewer scans around: half of them, then.
int enoughOf(std::size_t members, const RegistrationParams& params) {
  return std::min(params.steady_scans, static_cast<int>(members + 1) / 2);
}

std::vector<KeyframeId> around(KeyframeId centre, const std::vector<Keyframe>& keyframes, KeyframeId limit,
                               const RegistrationParams& params) {
  return submapMembers(keyframes, centre, limit, params.submap_reach_m, params.submap_max_each_side);
}

}  // namespace

Cloud loopScan(const Cloud& cloud, const RegistrationParams& params) {
  if (params.min_intensity <= 0 || !cloud.hasIntensity()) return selected(cloud, onePerVoxel(cloud, params.voxel_m));
  Cloud strong;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (static_cast<double>(cloud.intensity[i]) >= params.min_intensity)
      strong.push(cloud.x[i], cloud.y[i], cloud.z[i]);
  return selected(strong, onePerVoxel(strong, params.voxel_m));
}

LoopTarget loopTarget(KeyframeId centre, const std::vector<Keyframe>& keyframes, KeyframeId limit,
                      const std::vector<Pose>& T_map_base, const KeyframeCloud& cloud_of,
                      const RegistrationParams& params, ThreadPool& threads) {
  const std::vector<KeyframeId> members = around(centre, keyframes, limit, params);
  LoopTarget target;
  target.clouds.resize(members.size());
  threads.forEachChunk(members.size(), 1,
                       [&](std::size_t i, std::size_t, std::size_t) { target.clouds[i] = cloud_of(members[i]); });
  std::vector<Cloud> placed = placedScans(
      members, centre, T_map_base, [&](KeyframeId k) { return target.clouds[k - members.front()]; });  // in a row
  if (const int enough = enoughOf(members.size(), params); enough > 1) {
    const std::vector<Cloud> all = std::move(placed);
    const SteadyPoints steady(all, params.steady_m, keyframes[centre].planar);
    placed.clear();
    for (std::size_t i = 0; i < all.size(); ++i) placed.push_back(steady.of(i, enough));
  }
  target.submap = joined(placed);
  for (const KeyframeId k : members) target.T_target_base.push_back(T_map_base[centre].inverse() * T_map_base[k]);
  return target;
}

Cloud loopQuery(KeyframeId k, const std::vector<Keyframe>& keyframes, KeyframeId limit,
                const std::vector<Pose>& T_map_base, const KeyframeCloud& cloud_of, const RegistrationParams& params) {
  const std::vector<KeyframeId> members = around(k, keyframes, limit, params);
  const int enough = enoughOf(members.size(), params);
  if (enough <= 1) return *cloud_of(k);
  const std::vector<Cloud> placed = placedScans(members, k, T_map_base, cloud_of);
  return SteadyPoints(placed, params.steady_m, keyframes[k].planar).of(k - members.front(), enough);
}

}  // namespace scslam
