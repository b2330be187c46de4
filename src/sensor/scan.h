// One sweep of a range sensor, as a reader hands it over.
#pragma once
#include <optional>
#include <string>

#include "scslam/core/cloud.h"
#include "scslam/core/stamp.h"

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
};

}  // namespace scslam
