// The rigid motion that lays one trajectory on another.
#pragma once
#include <vector>

#include "scslam/core/pose.h"

namespace scslam {

/// Of poses measured whole: a degree weighs like 17 cm. The positions of a straight drive leave its roll to the noise.
inline constexpr double kOrientationLever_m = 5;

/// Least-squares rigid alignment without scale (Umeyama, PAMI 1991, c = 1): the T_a_b that minimises
/// sum |p_a,i - T_a_b p_b,i|^2 over the positions. What positions leave open (all of them on a line, in one place, or a
/// single one) is decided by the orientations; where they fix everything these have no say unless `lever_m` gives it.
/// @param a, b the same poses seen in frame a and in frame b, equally many. None: identity.
/// @param lever_m each pose counts as six more points, this far along its axes. 0, as in published ATE: centimetres of
///        noise across a straight drive turn it about itself.
Pose alignPoses(const std::vector<Pose>& a, const std::vector<Pose>& b, double lever_m = 0);

}  // namespace scslam
