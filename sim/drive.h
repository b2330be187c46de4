// From a route on the ground to the exact motion of a robot on it: speeds, stops, wheels on rough ground, a body on
// springs.
#pragma once
#include <functional>

#include "scslam/core/params.h"
#include "sim/trajectory.h"
#include "sim/world.h"

namespace scslam::sim {

/// YAML group `drive` of a scenario.
struct DriveParams : ParamSetOf<DriveParams> {
  std::string route;                 ///< of the world; empty: its first
  std::vector<double> points;        ///< own route instead: x y x y … [m]
  bool closed = false;               ///< own route only
  double laps = 1;                   ///< of a closed route; may be broken
  double lane_m = 0;                 ///< the robot keeps so far to the left of the route
  std::vector<double> lap_offset_m;  ///< more to the left in lap 1, 2, …; the last stays
  double speed_mps = 8, accelerate_mps2 = 1.5, corner_mps2 = 2.5, turn_radius_m = 6;
  double start_pause_s = 0.5;
  std::vector<double> stops_m;  ///< distances travelled at which it stops
  double stop_s = 2;
  double duration_s = 60;  ///< the drive is cut here
  double wheelbase_m = 2.7, track_m = 1.6;
  double lean_deg_per_mps2 = 0.5;  ///< the body's pitch and roll for each m/s^2
  void describe(ParamVisitor& visitor) override;
};

/// Height of the ground near (x, y, z_hint); NaN where there is none.
using GroundHeight = std::function<double(double x, double y, double z_hint)>;

/// @throw usageError when there is no such route, or it is shorter than 1 m.
Trajectory planDrive(const DriveParams& params, const std::vector<Route>& routes, const GroundHeight& ground);

}  // namespace scslam::sim
