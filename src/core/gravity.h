#pragma once
#include "scslam/core/cloud.h"

namespace scslam {

/// R_level_base: turns the base frame upright using the roll and pitch of T_odom_base, keeping its heading
/// (Rz(yaw) R_level_base = R_odom_base; odom's z axis is taken as up).
Eigen::Matrix3d levelling(const Pose& T_odom_base);

/// Height of the ground [m] under the sensor in a levelled frame: the 5th percentile of z within `radius_m`, to 0.05 m.
/// @return 0 for an empty cloud.
double groundHeight(const Cloud& cloud_level, double radius_m = 30.0);

}  // namespace scslam
