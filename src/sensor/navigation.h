// What comes with the scans: inertial and satellite readings, raw.
#pragma once
#include "scslam/core/pose.h"
#include "scslam/core/stamp.h"

namespace scslam {

/// One reading of an inertial sensor, in its own frame.
struct ImuSample {
  Stamp stamp;
  Eigen::Vector3d gyro_rad_s = Eigen::Vector3d::Zero();
  /// Specific force: at rest it points up with the length of gravity.
  Eigen::Vector3d accel_m_s2 = Eigen::Vector3d::Zero();
};

/// One satellite fix of the antenna.
struct GnssFix {
  Stamp stamp;
  double latitude_deg = 0, longitude_deg = 0;                   ///< WGS 84
  double height_m = 0;                                          ///< above the ellipsoid
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Identity();  ///< east, north, up
  Eigen::Vector3d antenna_in_base_m = Eigen::Vector3d::Zero();  ///< lever arm
};

}  // namespace scslam
