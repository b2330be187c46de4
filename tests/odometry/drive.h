// A robot that drives through the room of tests/support, seen by a sensor on its roof.
#pragma once
#include <vector>

#include "scslam/sensor/scan.h"
#include "support/support.h"

namespace scslam::test {

struct Drive {
  std::vector<Pose> T_world_base;  ///< truth
  std::vector<Scan> scans;
};

inline Pose T_base_sensor() { return poseFromYaw(0.4, {0.3, 0.1, 1.2}); }

/// The room as seen at T_world_base: different points of its surfaces each time.
inline Scan scanAt(std::size_t index, const Pose& T_world_base, std::size_t points = 12000) {
  Scan scan;
  scan.index = index;
  scan.stamp = stampFromSeconds(1000.0 + 0.1 * static_cast<double>(index));
  scan.T_base_sensor = T_base_sensor();
  scan.cloud = transformed(aRoom(points, static_cast<std::uint32_t>(index) + 10, 0.01),
                           (T_world_base * T_base_sensor()).inverse());
  scan.cloud.intensity.assign(scan.cloud.size(), 0.5f);
  scan.T_odom_base = T_world_base;
  return scan;
}

/// An arc of 0.15 m and 2 degrees a step.
inline Drive arc(std::size_t steps) {
  Drive drive;
  Pose T = poseFromYaw(0.2, {-4, -1, 0});
  for (std::size_t k = 0; k < steps; ++k) {
    drive.T_world_base.push_back(T);
    drive.scans.push_back(scanAt(k, T));
    T = T * poseFromYaw(0.035, {0.15, 0.01, 0});
  }
  return drive;
}

}  // namespace scslam::test
