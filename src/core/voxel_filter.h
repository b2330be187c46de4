// Deterministic down-sampling: one point a voxel.
#pragma once
#include <cstdint>
#include <vector>

#include "scslam/core/cloud.h"

namespace scslam {

/// Numbers of the points kept: finite, min_range <= |p| <= max_range [m] from the cloud's origin, and of those in one
/// voxel of size voxel_m (corners at multiples of voxel_m) one drawn by lot, always the same for the same cloud. In
/// increasing order. voxel_m > 0.
///
/// Not the first of the voxel: scans are in the order of the sweep, and the first to cross a voxel's face is most often
/// one that its range noise has pushed across. On walls seen askance such points stand out to one side, ahead to the
/// other than behind, and a map of them bends.
std::vector<std::uint32_t> onePerVoxel(const Cloud& cloud, double voxel_m, double min_range_m = 0.0,
                                       double max_range_m = 1e4);

/// The mean point of each voxel, in the order in which the voxels first appear; coordinates only. Points that are not
/// finite or farther than 10 km are dropped.
Cloud centroidPerVoxel(const Cloud& cloud, double voxel_m);

/// The coordinates of some points of a cloud.
Cloud selected(const Cloud& cloud, const std::vector<std::uint32_t>& points);

}  // namespace scslam
