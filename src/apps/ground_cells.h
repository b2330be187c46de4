// How high is a point above the ground around it? From the lowest points that several scans have of each place, so that
// the underside of something that hid the ground from one of them is not taken for it.
#pragma once
#include <vector>

#include "scslam/core/cloud.h"
#include "scslam/core/voxel_index.h"

namespace scslam {

/// The lowest point of one scan in a cell of 0.5 m.
struct LowPoint {
  VoxelKey cell;
  float z;  ///< frame map [m]
};

/// Of all cells within reach of the sensor, by cell. @param cloud_map frame map, z up.
std::vector<LowPoint> lowPoints(const Cloud& cloud_map, const Eigen::Vector3f& sensor_map, float reach_m = 40);

class GroundCells {
 public:
  static constexpr float kCell_m = 0.5F;
  /// @param scans what lowPoints() gave for scans of the same surroundings.
  explicit GroundCells(const std::vector<const std::vector<LowPoint>*>& scans);
  /// Height of p over the ground of its cell, or of the cells around it; infinite where none is known.
  float heightOf(const Eigen::Vector3f& p_map) const;
  /// Of the ground there [m]; not finite where none is known.
  float groundAt(float x, float y) const { return -heightOf({x, y, 0}); }

 private:
  VoxelIndex index_;
  std::vector<float> z_;
};

}  // namespace scslam
