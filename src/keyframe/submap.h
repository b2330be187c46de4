// The target of a loop's registration: the scans around a place, each at its own pose.
#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "scslam/keyframe/keyframe.h"

namespace scslam {

/// Gives the cloud of a keyframe, frame base.
using KeyframeCloud = std::function<std::shared_ptr<const Cloud>(KeyframeId)>;

/// Keyframes within `reach_m` of path before and after `centre`, at most `max_each_side` on a side, oldest first.
/// Only keyframes [0, limit) are considered (a submap must not contain the scan that is registered against it), and
/// none beyond a step on which odometry lost track: where those lie is not known.
std::vector<KeyframeId> submapMembers(const std::vector<Keyframe>& keyframes, KeyframeId centre, KeyframeId limit,
                                      double reach_m, int max_each_side);

/// Their clouds in the base frame of keyframe `centre`, every scan at its own current pose (the classic bug placed all
/// of them at the pose of one, facts on SC-A-LOAM).
std::vector<Cloud> placedScans(const std::vector<KeyframeId>& members, KeyframeId centre,
                               const std::vector<Pose>& T_map_base, const KeyframeCloud& cloud_of);
/// All points in one; coordinates only.
Cloud joined(const std::vector<Cloud>& clouds);

}  // namespace scslam
