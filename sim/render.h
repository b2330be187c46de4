// Pictures of a world and of a scan, ray traced, without a screen.
#pragma once
#include <string>
#include <vector>

#include "scslam/core/image.h"
#include "scslam/core/parallel.h"
#include "sim/lidar.h"
#include "sim/ray_scene.h"

namespace scslam::sim {

/// The world from straight above, with the drive drawn in: PNG bytes.
std::string renderTop(const RayScene& scene, const Eigen::AlignedBox3f& bounds, const Trajectory& drive,
                      ThreadPool& threads);
/// The world from behind and above the robot at t.
std::string renderOblique(const RayScene& scene, const Trajectory& drive, double t, ThreadPool& threads);
/// A scan: its range image on top, seen from above below; colours by class.
std::string renderScan(const LidarScan& scan, const Lidar& lidar);

}  // namespace scslam::sim
