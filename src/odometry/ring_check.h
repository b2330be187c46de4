// Are these the rings of this sensor? A table of another sensor gives every point a ring all the same, and a method
// that works along rings then finds edges everywhere and says nothing.
#pragma once
#include <string>
#include <vector>

#include "scslam/odometry/scan_rings.h"

namespace scslam {

/// @param slope of each point as the sensor sees it: the tangent of its elevation.
/// @return why each ring cannot be the sweep of one laser of its own, to go on after "but"; empty: it can.
std::string doubtAboutRings(const ScanRings& rings, const std::vector<float>& slope);

/// @param levels ascending, the slopes of the beams that somebody gave for this sensor.
/// @return why the points cannot come from them, to go on after "but"; empty: they can.
std::string doubtAboutBeams(const std::vector<float>& levels, const std::vector<float>& slope);

}  // namespace scslam
