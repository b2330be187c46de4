// The true motion of the robot: a cumulative cubic B-spline on SE(3) (positions and rotations apart), twice
// continuously differentiable, so that every firing, every IMU sample and every truth line has its exact pose.
// Derivatives: Sommer et al., "Efficient derivative computation for cumulative B-splines on Lie groups", CVPR 2020.
#pragma once
#include <vector>

#include "scslam/core/pose.h"

namespace scslam::sim {

/// Pose and motion of the base at one instant.
struct MotionState {
  Pose T_world_base = Pose::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();              ///< of the base origin, world frame [m/s]
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();          ///< world frame [m/s^2], without gravity
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();      ///< base frame [rad/s]
  Eigen::Vector3d angular_acceleration = Eigen::Vector3d::Zero();  ///< base frame [rad/s^2]
};

class Trajectory {
 public:
  /// @param control poses T_world_base every knot_s seconds; at least 4. Time 0 is at control pose 1, the end at the
  /// last but one. The curve stays within the hull of its control poses (it smooths them).
  Trajectory(std::vector<Pose> control, double knot_s);
  double duration() const;            ///< [s]
  Pose pose(double t) const;          ///< t outside [0, duration] is clamped
  MotionState state(double t) const;  ///< likewise
  double length() const;              ///< distance travelled [m], by steps of a knot

 private:
  struct Segment {
    std::size_t first;
    double u;
  };
  Segment segment(double t) const;
  std::vector<Pose> control_;
  std::vector<Eigen::Vector3d> turn_;  ///< Log(R_i^-1 R_i+1)
  double knot_s_;
};

}  // namespace scslam::sim
