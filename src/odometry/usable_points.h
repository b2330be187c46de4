// What of a scan can be matched to a local map, and how fine that map should be.
#pragma once
#include "scslam/sensor/scan.h"

namespace scslam {

/// The finite points between these ranges of the sensor, in frame base, all fields kept.
/// @param min_range_m 0: 1.0, 0.1 for planar scans.
Cloud usablePoints(const Scan& scan, double min_range_m, double max_range_m);

/// Fewer are too few to match.
inline std::size_t leastPoints(bool planar) { return planar ? 20 : 60; }

/// Edge of the finest voxels that suit a scan: a twentieth of the median range [m]. @param cloud not empty.
double voxelFor(const Cloud& cloud, bool planar);

}  // namespace scslam
