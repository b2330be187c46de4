// Is the scale of a radar's motion right? A wrong range resolution stretches everything the radar measures; another
// source of the same motion tells.
#pragma once
#include <optional>
#include <string>

#include "scslam/core/geodesy.h"
#include "scslam/core/trajectory.h"
#include "scslam/sensor/scan.h"

namespace scslam {

struct MotionScale {
  double scale = 1;  ///< estimate / reference, the median over the stretches
  double sigma = 0;  ///< of that median, from the scatter of the stretches
  std::size_t stretches = 0;
};

/// Compares the straight distances of both over stretches of the reference that are stretch_m long.
/// @return nullopt with fewer than 5 stretches.
std::optional<MotionScale> motionScale(const Trajectory& estimate, const Trajectory& reference, double stretch_m = 10);

/// What a recording itself says of the motion, collected while it is read: wheel odometry where there is any, otherwise
/// satellite fixes.
class MotionReference {
 public:
  void add(const Scan& scan);
  /// @param truth of the recording: taken before anything else. @param source which it was, for people.
  std::optional<Trajectory> trajectory(const std::optional<Trajectory>& truth, std::string& source) const;

 private:
  Trajectory odometry_, satellites_;
  std::optional<LocalEnu> enu_;
};

/// The verdict in words, with the resolution that would fit; empty when the scale is within 3 % or three sigmas of 1.
std::string scaleComplaint(const MotionScale& scale, double range_resolution_m, const std::string& reference);

}  // namespace scslam
