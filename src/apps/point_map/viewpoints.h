// Where could a robot have stood to see a map? On its ground, clear of what stands on it.
#pragma once
#include <vector>

#include "scslam/core/cloud.h"

namespace scslam {

/// Places on the ground of the map, about spacing_m apart, in the order of a tour that goes on to the nearest one left.
/// Ground counts where a robot fits and enough of it hangs together (roofs of cars and houses seldom do).
/// @param cloud_map frame map, z up. @return points of the ground [m]; none where there is no such ground.
std::vector<Eigen::Vector3f> groundViewpoints(const Cloud& cloud_map, double spacing_m);

}  // namespace scslam
