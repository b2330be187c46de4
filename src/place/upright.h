// A keyframe's cloud as a person would draw it: turned upright by gravity, heights counted from the ground. What place
// images are made of, so that tilted and hand-held sensors work and nobody has to state the height of theirs.
#pragma once
#include <cstddef>

#include "scslam/keyframe/keyframe.h"

namespace scslam {

/// How a cloud of frame base stands in the upright frame: origin and heading of base, z up.
struct Upright {
  Eigen::Matrix3f R_level_base = Eigen::Matrix3f::Identity();
  float ground_m = 0;   ///< z of the ground under the sensor in the upright frame
  bool planar = false;  ///< 2-D data: every point counts as 1 m high
};

/// Roll and pitch from keyframe.T_odom_base; the ground from the cloud (of at most about 8 000 of its points).
Upright uprightOf(const Keyframe& keyframe, const Cloud& cloud_base);

/// Points of a block in the upright frame; height above the ground. Points beyond `count` are NaN.
struct UprightBlock {
  static constexpr std::size_t kSize = 512;
  alignas(32) float x[kSize], y[kSize], height[kSize];
  std::size_t count = 0;
};

/// Fills `block` with the points begin .. begin + kSize of the cloud, moved by `left_m` to the right (as seen from
/// `left_m` to the left of base).
void uprightBlock(const Cloud& cloud_base, const Upright& upright, std::size_t begin, float left_m,
                  UprightBlock& block);

/// The outline: the highest point of every square cell within +-radius_m, x y z with z above the ground, upright. Much
/// smaller than the cloud, and images of it are nearly those of the cloud.
Cloud outline(const Cloud& cloud_base, const Upright& upright, double cell_m, double radius_m);

}  // namespace scslam
