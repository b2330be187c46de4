// How far a scan saw, direction by direction, from where its sensor stood.
#pragma once
#include <cstdint>
#include <vector>

#include "scslam/core/cloud.h"

namespace scslam {

/// What a scan says of a point of space.
enum class Sight : std::uint8_t {
  kUnknown,  ///< no return in that direction, or too near the sensor to tell
  kSurface,  ///< about where the scan saw a surface
  kFree,     ///< the scan saw through it, in all directions around it
  kBehind    ///< hidden by what the scan saw
};

/// The nearest and the farthest return per cell of azimuth and elevation. Cells are wide enough for scans thinned to a
/// point per 0.3 m; a question is answered by a cell and its eight neighbours, so a small error of pose does not
/// matter.
class RangeImage {
 public:
  /// @param viewpoint the sensor's place in the cloud's frame. @param planar one row: elevations do not count.
  RangeImage(const Cloud& cloud, const Eigen::Vector3f& viewpoint, bool planar);

  /// @param p in the cloud's frame. @param margin_m how much nearer than everything seen around it is clearly free.
  Sight at(const Eigen::Vector3f& p, float margin_m) const;
  const Eigen::Vector3f& viewpoint() const { return viewpoint_; }

 private:
  struct Cell {
    float nearest, farthest;
  };
  /// Cell number and range of the direction viewpoint -> p; range 0 where it has none.
  std::size_t cellOf(const Eigen::Vector3f& p, float& range_m) const;
  void spread(const std::vector<Cell>& seen);

  Eigen::Vector3f viewpoint_;
  bool planar_;
  std::size_t rows_;
  std::vector<Cell> around_;  ///< over a cell and its neighbours; farthest < 0: the cell itself saw nothing
};

}  // namespace scslam
