#pragma once
#include <optional>
#include <vector>

#include "scslam/keyframe/keyframe.h"

namespace scslam {

/// How a keyframe lies to the nearest earlier place.
struct NearestPlace {
  KeyframeId match = 0;
  double distance_m = 0;
  double heading_deg = 0;  ///< |difference of headings|, 0 .. 180
  double lateral_m = 0;    ///< |offset across the earlier keyframe's driving direction|
};

/// For each keyframe with truth the nearest earlier one within `reach_m` (in space, so that floors of a garage stay
/// apart) that lies at least `min_travel_m` of way before it.
std::vector<std::optional<NearestPlace>> nearestPlaces(const std::vector<Keyframe>& keyframes,
                                                       const std::vector<std::optional<Pose>>& T_truth_base,
                                                       double reach_m, double min_travel_m);

}  // namespace scslam
