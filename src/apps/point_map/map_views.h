// A cloud of points as a scanner would see it from a place in it.
#pragma once
#include <array>
#include <vector>

#include "scslam/core/cloud.h"
#include "scslam/core/voxel_index.h"

namespace scslam {

class MapViews {
 public:
  /// @param cloud_map frame map; kept. @param range_m how far the scanner sees.
  MapViews(Cloud cloud_map, double range_m);
  /// What is not hidden from there, at most one point for each direction of a fine scanner; axes of the map, origin at
  /// the viewpoint. From several threads.
  Cloud from(const Eigen::Vector3f& viewpoint_map) const;

 private:
  std::vector<std::uint32_t> around(const Eigen::Vector3f& viewpoint_map) const;

  Cloud cloud_;
  float range_m_;
  VoxelIndex squares_;
  std::vector<std::vector<std::uint32_t>> by_square_;  ///< points
};

}  // namespace scslam
