// Which points of one scan belong to something that moves?
#pragma once
#include <vector>

#include "scslam/apps/clean/clean.h"
#include "scslam/apps/clean/objects.h"
#include "scslam/apps/clean/sight_image.h"

namespace scslam {

struct ScanVerdict {
  std::vector<std::uint8_t> dynamic;  ///< by point
  std::size_t objects = 0;            ///< that move
  std::size_t reverted = 0;           ///< points that the views refused and their surroundings saved
  std::size_t completed = 0;          ///< points removed as part of an object that moves, without a vote of their own
};

/// @param soon, later votes of the scans just before and after, and of others. @param T_level_sensor to a frame whose z
/// points up. @param height of each point over the ground [m]; infinite where it is not known.
ScanVerdict judgeScan(const Cloud& cloud_sensor, const std::vector<float>& height, const SightVotes& soon,
                      const SightVotes& later, const Pose& T_level_sensor, const CleanParams& params);

}  // namespace scslam
