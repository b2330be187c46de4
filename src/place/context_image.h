// The two images of Scan Context++ (G. Kim, S. Choi, A. Kim, "Scan Context++", T-RO 2021, Sec. IV), re-implemented from
// the paper: a bin holds the height above the ground [m] of its highest point, 0 where it is empty.
#pragma once
#include "scslam/place/place_recogniser.h"
#include "scslam/place/upright.h"

namespace scslam {

/// Polar Context: row = ring (near to far), column = sector (counter-clockwise from straight ahead). Turning the robot
/// shifts the columns.
struct PolarGrid {
  int rings = 20, sectors = 60;
  double max_radius_m = 80;
};
/// @param left_m as if the scan had been taken this far to the left (the augmentation of A-PC).
Descriptor polarContext(const Cloud& cloud_base, const Upright& upright, const PolarGrid& grid, double left_m = 0);
/// The same from a stored image instead of the cloud, each bin spread over its area: coarse, but needs nothing else.
Descriptor polarContext(const Descriptor& polar, const PolarGrid& grid, double left_m);

/// Cart Context: row = along the driving direction (rear to front), column = across it (right to left). Changing the
/// lane shifts the columns.
struct CartGrid {
  int rows = 40, columns = 40;
  double reach_ahead_m = 100;  ///< x from -reach to +reach
  double reach_aside_m = 40;
};
Descriptor cartContext(const Cloud& cloud_base, const Upright& upright, const CartGrid& grid);

}  // namespace scslam
