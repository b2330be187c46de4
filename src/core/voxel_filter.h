// Deterministic down-sampling: one point a voxel, in input order.
#pragma once
#include <cstdint>
#include <vector>

#include "scslam/core/cloud.h"

namespace scslam {

/// Numbers of the points kept: finite, min_range <= |p| <= max_range [m] from the cloud's origin, and the first of
/// their voxel of size voxel_m (voxel corners at multiples of voxel_m). In increasing order. voxel_m > 0.
std::vector<std::uint32_t> firstPerVoxel(const Cloud& cloud, double voxel_m, double min_range_m = 0.0,
                                         double max_range_m = 1e4);

/// The mean point of each voxel, in the order in which the voxels first appear; coordinates only. Points that are not
/// finite or farther than 10 km are dropped.
Cloud centroidPerVoxel(const Cloud& cloud, double voxel_m);

/// The coordinates of some points of a cloud.
Cloud selected(const Cloud& cloud, const std::vector<std::uint32_t>& points);

}  // namespace scslam
