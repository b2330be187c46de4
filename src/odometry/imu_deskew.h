// Motion compensation of a sweep along the motion that an inertial sensor measured.
#pragma once
#include <vector>

#include "scslam/core/cloud.h"
#include "scslam/odometry/imu_preintegration.h"

namespace scslam {

/// Poses of the base during a sweep, at equal times, relative to the base at the scan's stamp: T_stamp_base(k * slice).
struct SweepMotion {
  double slice_s = 0;
  std::vector<Pose> poses;  ///< the first is the identity; empty: no motion
};

/// @param readings from the scan's stamp to the end of the sweep (ImuStream::between()); empty gives no motion.
/// @param state of the IMU at the scan's stamp, in the frame `gravity` is in.
SweepMotion sweepMotion(const std::vector<ImuReading>& readings, const NavState& state, const ImuBias& bias,
                        const Eigen::Vector3d& gravity, const Pose& T_base_imu);

/// The same speed all the time. @param twist (v, w) of the base, frame base.
SweepMotion sweepMotion(const Vector6d& twist, double sweep_s);

/// Moves each point (frame base at its own time dt after the stamp) to frame base at the stamp. Times before the stamp
/// count as the stamp, times after the end as the end.
void deskew(Cloud& cloud, const SweepMotion& motion);

}  // namespace scslam
