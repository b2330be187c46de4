// How far a trajectory is from the truth: absolute and relative errors.
#pragma once
#include <string>
#include <vector>

#include "scslam/core/pose.h"

namespace scslam {

struct AbsoluteError {
  double rmse_m = 0, max_m = 0;
  double level_rmse_m = 0;                   ///< in x and y of the estimate's frame: all that planar data says
  Pose T_truth_estimate = Pose::Identity();  ///< the alignment
};
/// Distances of positions after alignPoses(truth, estimate).
AbsoluteError absoluteError(const std::vector<Pose>& truth, const std::vector<Pose>& estimate);

/// Errors over segments of fixed length, as the KITTI odometry benchmark counts them.
struct RelativeError {
  double trans_percent = 0, rot_deg_per_m = 0;  ///< means over all segments; 0 when there is none
  std::size_t segments = 0;
  std::vector<double> lengths_m;  ///< those that the drive is long enough for
};
/// Lengths are 100, 200 … 800 m along the truth; a drive that has no 100 m takes 10 … 80 m, then 1 … 8 m. A segment
/// starts at every pose, of a thousand poses or more at every tenth (the benchmark's step), and ends at the first pose
/// beyond its length; the error is divided by the length of the benchmark, not by the way actually driven.
RelativeError relativeError(const std::vector<Pose>& truth, const std::vector<Pose>& estimate);
/// The same of x, y and heading alone, in the estimate's frame: what planar data is judged by, as benchmarks of radar
/// odometry are. A robot that pitches by half a degree is a metre higher 100 m on, for a sensor that sees neither.
RelativeError levelRelativeError(const std::vector<Pose>& truth, const std::vector<Pose>& estimate);

/// Way driven up to each pose [m].
std::vector<double> travelled(const std::vector<Pose>& poses);

}  // namespace scslam
