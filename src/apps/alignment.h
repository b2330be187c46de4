// The rigid motion that lays one trajectory on another.
#pragma once
#include <vector>

#include "scslam/core/pose.h"

namespace scslam {

/// Least-squares rigid alignment without scale (Umeyama, PAMI 1991, c = 1): the T_a_b that minimises
/// sum |p_a,i - T_a_b p_b,i|^2 over the positions. What positions leave open (all of them on a line, in one place, or a
/// single one) is decided by the orientations; where they fix everything these have no say.
/// @param a, b the same poses seen in frame a and in frame b, equally many. None: identity.
Pose alignPoses(const std::vector<Pose>& a, const std::vector<Pose>& b);

}  // namespace scslam
