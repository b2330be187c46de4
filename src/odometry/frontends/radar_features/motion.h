// The motion between two sweeps from pairs of features, each at its own instant: motion-compensated RANSAC (K. Burnett,
// A. Schoellig, T. Barfoot, "Do we need to compensate for motion distortion and Doppler effects in spinning radar
// navigation?", RA-L 2021) after pairs were pruned that do not agree with the others on distances.
#pragma once
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

namespace scslam::radar_features {

/// The same thing seen at `a` in the later sweep and at `b` in the earlier one, each in frame base at its instant.
struct Pair {
  Eigen::Vector2d a, b;
  double time = 1;                   ///< from b's instant to a's, in the unit of the twist
  Eigen::Vector2d a_still, b_still;  ///< in frame base at their sweeps' stamps, as far as the motion is guessed
};

/// Keeps the pairs that agree with at least half of those kept on the distances between them (a rigid world keeps
/// distances): the ones that agree with the fewest go first.
std::vector<Pair> pruned(const std::vector<Pair>& pairs, double tolerance_m);

/// Constant velocity of the base in the plane (x, y, yaw), and of the radar on it.
struct MotionModel {
  Eigen::Vector2d sensor{0, 0};  ///< where it is in frame base [m]
  double doppler_beta = 0;       ///< in the unit of time of the twist; 0: none
};

struct MotionOptions {
  int iterations = 200;
  double inlier_m = 0.35;
  std::uint32_t seed = 1;
};

struct Motion {
  Eigen::Vector3d twist{0, 0, 0};  ///< frame base
  std::vector<std::uint32_t> inliers;
  std::vector<double> residuals;  ///< of the inliers [m]
  bool found = false;
};

/// The motion in the plane that a constant twist makes in this time: an arc.
Eigen::Isometry2d moved(const Eigen::Vector3d& twist, double time);
/// The twist that moves so in this time: the inverse of moved().
Eigen::Vector3d twistOfMotion(const Eigen::Isometry2d& T, double time);
/// moved(twist, time) * a - b with the Doppler shift of both undone.
Eigen::Vector2d residualOf(const Pair& pair, const Eigen::Vector3d& twist, const MotionModel& model);

/// Hypotheses from two pairs each, the one with the most inliers refined on them. The same pairs and seed give the same
/// motion. @param twist where to begin.
Motion motionOf(const std::vector<Pair>& pairs, const Eigen::Vector3d& twist, const MotionModel& model,
                const MotionOptions& options);

}  // namespace scslam::radar_features
