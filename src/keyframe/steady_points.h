// Which points of a scan do the scans around it show, too? What stands is seen from every place nearby; clutter that
// flickers and what drives past is not.
#pragma once
#include <cstdint>
#include <vector>

#include "scslam/core/cloud.h"
#include "scslam/core/voxel_index.h"

namespace scslam {

class SteadyPoints {
 public:
  /// @param scans in one frame; outlive this. @param near_m how near a point of another scan confirms a point: cubes of
  /// this size that touch. @param planar squares instead: heights do not count.
  SteadyPoints(const std::vector<Cloud>& scans, double near_m, bool planar);

  /// The points of scan `number` that at least `scans` scans show, itself included; coordinates only. Beyond 64 scans
  /// neighbours among them count as one.
  Cloud of(std::size_t number, int scans) const;

 private:
  VoxelCoord cellOf(const Eigen::Vector3f& p) const;
  std::uint64_t scansAround(const Eigen::Vector3f& p) const;

  const std::vector<Cloud>& scans_;
  float inverse_size_;
  bool planar_;
  VoxelIndex index_;
  std::vector<std::uint64_t> seen_by_;  ///< by cell, a bit for each scan
};

}  // namespace scslam
