// Motion compensation of a sweep: every point where it would have been seen at the scan's stamp.
#pragma once
#include "scslam/core/cloud.h"

namespace scslam {

/// Maps each point by the motion during its dt: p <- [Exp(dt w), dt v] p.
/// @param cloud frame base at the point's own instant; becomes frame base at the stamp. Without dt: unchanged.
/// @param twist (v [m/s], w [rad/s]) of the base, constant during the sweep, frame base.
void deskew(Cloud& cloud, const Vector6d& twist);

/// Longest |dt| of the cloud [s], 0 without times. NaN times count as 0.
double sweepDuration(const Cloud& cloud);

/// Mean dt of the points [s], 0 without times. NaN times count as 0.
double meanTime(const Cloud& cloud);

}  // namespace scslam
