// What a loop is registered with: a keyframe's scan, and the scans around the place it looks like.
#pragma once
#include <vector>

#include "scslam/core/parallel.h"
#include "scslam/keyframe/submap.h"
#include "scslam/pipeline/slam_params.h"
#include "scslam/registration/loop_verifier.h"

namespace scslam {

/// A scan as loops see it, in its own frame: strong enough, one point a voxel; coordinates only.
Cloud loopScan(const Cloud& cloud, const RegistrationParams& params);

/// The scans around keyframe `centre`, of what is steady (RegistrationParams::steady_scans).
/// @param limit only keyframes before it are considered. @param cloud_of loopScan() of each, frame base; called from
/// several threads.
LoopTarget loopTarget(KeyframeId centre, const std::vector<Keyframe>& keyframes, KeyframeId limit,
                      const std::vector<Pose>& T_map_base, const KeyframeCloud& cloud_of,
                      const RegistrationParams& params, ThreadPool& threads);

/// The scan of keyframe k, frame base, of what the scans around it show to be steady.
Cloud loopQuery(KeyframeId k, const std::vector<Keyframe>& keyframes, KeyframeId limit,
                const std::vector<Pose>& T_map_base, const KeyframeCloud& cloud_of, const RegistrationParams& params);

}  // namespace scslam
