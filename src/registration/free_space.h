// A scan must not see through walls: what tells a true overlap from a place that merely looks alike where both have
// something. Walls are upright planes taller than a car, so that what drove away, and bushes, say nothing.
#pragma once
#include "scslam/core/voxel_surface.h"
#include "scslam/registration/range_image.h"

namespace scslam {

/// The planes of a cloud, one patch per voxel, in the cloud's frame.
struct Patches {
  std::vector<Eigen::Vector3f> points;   ///< mean of the patch's points [m]
  std::vector<Eigen::Vector3f> normals;  ///< unit; the sign means nothing
  std::vector<std::uint8_t> wall;        ///< 1: part of a wall
};

/// @param voxel_m side of a patch. A wall is upright and at least three patches high (planar: any line).
Patches patchesOf(const Cloud& cloud, double voxel_m, bool planar);

/// Side of a patch that suits a cloud [m]: 1; planar: a tenth of the median range, 0.3 .. 2.
double patchSize(const Cloud& cloud, bool planar);

/// What a scan sees of some patches.
struct SightFigures {
  std::size_t seen = 0, seen_walls = 0;        ///< patches it sees, or sees through where it should see them
  std::size_t through = 0, through_walls = 0;  ///< of these, seen through

  /// Share of the patches in sight that are there; 1 where hardly any is in sight.
  double explained() const { return seen >= kFew ? 1 - static_cast<double>(through) / static_cast<double>(seen) : 1; }
  /// Share of the walls in sight that are seen through; 0 where hardly any is in sight.
  double throughWalls() const {
    return seen_walls >= kFew ? static_cast<double>(through_walls) / static_cast<double>(seen_walls) : 0;
  }

  static constexpr std::size_t kFew = 20;  ///< fewer patches than this say nothing
};

/// @param image of the scan, frame a. @param margin_m see RangeImage::at().
SightFigures sightOf(const RangeImage& image, const Patches& patches_b, const Pose& T_a_b, float margin_m);

}  // namespace scslam
