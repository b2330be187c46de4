// What one scan says of points that others measured: something is there, or it was looked through.
#pragma once
#include <cstdint>
#include <vector>

#include "scslam/core/cloud.h"

namespace scslam {

/// The directions of a sensor as cells of azimuth and elevation, the same for all scans of a session. Cells are a
/// little higher than the beams lie apart, so that every cell in the field of view is hit when there is something to
/// hit.
struct SightGrid {
  std::size_t columns = 0, rows = 0;
  float column_rad = 0, row_rad = 0;
  float lowest_rad = 0;             ///< elevation of the lower edge of row 0
  std::vector<std::uint8_t> fires;  ///< 1: the sensor was seen to measure there; by row, then column
  bool planar = false;              ///< one row: elevations do not count

  std::size_t at(std::size_t row, std::size_t column) const { return row * columns + column; }
};

/// @param samples some scans of the sensor, frame sensor; the more, the better `fires` is known.
SightGrid sightGridOf(const std::vector<Cloud>& samples, bool planar);

/// How many scans looked through each point of a cloud, and how many saw something there.
struct SightVotes {
  std::vector<std::uint8_t> free, surface;
  explicit SightVotes(std::size_t points) : free(points), surface(points) {}
};

struct SightMargins {
  float margin_m = 0.25F, margin_per_m = 0.01F;  ///< how much nearer is nearer: margin_m + margin_per_m * range
  float nearest_m = 1, sky_m = 40;  ///< no vote on nearer points; up to sky_m a beam without return looked through
};

/// The ranges of one scan. A direction is judged by the four cells around it, so that an oblique surface lies between
/// what is nearest and what is farthest there, and neither rounding nor a small error of pose makes it look pierced.
class SightImage {
 public:
  SightImage(const Cloud& cloud_sensor, const SightGrid& grid);

  /// One vote, or none, on each point of `cloud`. @param grid the one given above. @param T_view_cloud to this scan's
  /// sensor frame. @param votes of as many points, at most 255 votes each.
  void vote(const Cloud& cloud, const Pose& T_view_cloud, const SightGrid& grid, const SightMargins& margins,
            SightVotes& votes) const;
  std::size_t bytes() const { return corners_.size() * sizeof(Corner); }

 private:
  /// Where four cells meet.
  struct Corner {
    float free_below;         ///< all that is nearer was looked through; 0: unknown, kSky: nothing came back
    float nearest, farthest;  ///< seen there; negative: nothing
  };
  std::vector<Corner> corners_;  ///< by row 0 .. rows, then column 0 .. columns - 1
};

}  // namespace scslam
