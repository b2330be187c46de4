// One sweep of a range sensor, as a reader hands it over.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scslam/core/cloud.h"
#include "scslam/core/stamp.h"
#include "scslam/sensor/navigation.h"
#include "scslam/sensor/radar_scan.h"

namespace scslam {

struct Scan {
  std::size_t index = 0;  ///< 0-based number of the scan in its source, counting unusable ones too
  Stamp stamp;            ///< start of the sweep
  Cloud cloud;            ///< frame: sensor; may hold NaN or be empty (preprocess() deals with it)
  Pose T_base_sensor = Pose::Identity();
  bool planar = false;    ///< a 2-D laser or radar: all points in one plane of the sensor frame
  bool deskewed = false;  ///< already motion-compensated by whoever recorded it
  std::string label;      ///< sensor label, for messages
  /// Where the recording itself says the robot was at `stamp` (wheel odometry, poses beside the scans); drifting.
  std::optional<Pose> T_odom_base;
  /// Inertial readings, in time order: those after the ones of the scan before, up to the end of this sweep or later
  /// (as far as the recording has them before the next scan). Each is handed over once.
  std::vector<ImuSample> imu;
  Pose T_base_imu = Pose::Identity();
  std::vector<GnssFix> gnss;  ///< likewise
  /// The image of a spinning radar. `cloud` is then empty until preprocess() has extracted points from it.
  std::shared_ptr<const RadarScan> radar;
};

}  // namespace scslam
