// A session keeps points; maps of power need the images, which are read again from the session's input.
#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "scslam/mapping/map_exporter.h"
#include "scslam/sensor/pose_track.h"
#include "scslam/sensor/radar_scan.h"
#include "scslam/sensor/scan_source.h"

namespace scslam {

/// Where the radar was at one azimuth of a sweep, in the map's plane.
struct AzimuthPose {
  bool known = false;            ///< measured, and the trajectory says where
  double x = 0, y = 0, yaw = 0;  ///< of the sensor, T_map_sensor
  double vx = 0, vy = 0;         ///< its velocity, in the map frame [m/s]
};

class RadarSweeps {
 public:
  /// @throw inputError when the input is gone or holds no radar.
  RadarSweeps(const MapInfo& info, const PluginContext& context);

  struct Sweep {
    std::shared_ptr<const RadarScan> image;
    std::vector<AzimuthPose> poses;  ///< per azimuth
  };
  /// The next sweep that the trajectory knows; nullopt after the last. Damage ends the sweeps, as it ended the run.
  std::optional<Sweep> next();

 private:
  std::unique_ptr<ScanSource> source_;
  PoseTrack trajectory_;  ///< T_map_base
  Stamp first_, last_;
};

}  // namespace scslam
