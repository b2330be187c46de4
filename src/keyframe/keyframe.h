#pragma once
#include <cstdint>
#include <memory>

#include "scslam/core/cloud.h"
#include "scslam/core/stamp.h"

namespace scslam {

using KeyframeId = std::uint32_t;  ///< 0-based, dense within a session

/// A place of the pose graph.
struct Keyframe {
  KeyframeId id = 0;
  std::size_t scan_index = 0;
  Stamp stamp;
  Pose T_odom_base = Pose::Identity();
  double travelled_m = 0;                       ///< path length in odom up to here
  Matrix6d step_covariance = Matrix6d::Zero();  ///< of T_previous_keyframe_this, frame base: what adds up (odometry.h)
  Vector6d step_passing = Vector6d::Zero();     ///< besides, variances of what does not
  bool planar = false;                          ///< 2-D data
};

}  // namespace scslam
