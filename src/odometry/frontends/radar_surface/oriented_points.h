// Oriented surface points of a radar sweep: where power was reflected, as means, spreads and directions of small
// groups of points (D. Adolfsson et al., "Lidar-level localization with radar? The CFEAR approach to accurate, fast and
// robust large-scale radar odometry in diverse environments", T-RO 2023).
#pragma once
#include <span>
#include <vector>

#include "scslam/core/bytes.h"
#include "scslam/core/cloud.h"
#include "scslam/core/voxel_index.h"

namespace scslam::radar_surface {

/// Structure of arrays, in the plane of the frame its owner states.
struct OrientedPoints {
  std::vector<float> x, y;    ///< mean [m]
  std::vector<float> nx, ny;  ///< direction in which the points spread least
  std::vector<float> across;  ///< variance of the points along (nx, ny) [m^2]
  std::vector<float> along;   ///< the same across it, >= across
  std::vector<float> count;   ///< points in it

  std::size_t size() const { return x.size(); }
  void save(ByteWriter& state) const;
  /// @throw inputError for arrays of different lengths.
  void load(ByteReader& state);
};

struct GroupRules {
  double radius_m = 3;  ///< of a group; the grid's cells are as large
  int min_points = 4;   ///< smaller groups are noise
};

/// One for each cell of a grid that holds points: all points within radius_m of a centre, weighted by their intensity
/// above the weakest of the cloud, where it has intensities. The centre starts at the mean of the cell's points and
/// moves to the group's mean a few times (mean shift): left where the cells are, which drive along with the robot,
/// groups would hold the motion back. In the order in which the cells appear in the cloud.
OrientedPoints orientedPoints(const Cloud& cloud, const GroupRules& rules);

/// Points by the cell they lie in; cells of size cell_m.
class PointGrid {
 public:
  PointGrid() = default;
  PointGrid(const std::vector<float>& x, const std::vector<float>& y, double cell_m);

  /// Calls visit(i) for the points in the cell of (px, py) and the eight around it: all within cell_m of it are there.
  template <class Visit>
  void near(float px, float py, Visit visit) const {
    const std::int32_t ci = cell(px), cj = cell(py);
    for (std::int32_t j = cj - 1; j <= cj + 1; ++j)
      for (std::int32_t i = ci - 1; i <= ci + 1; ++i) {
        const std::uint32_t number = index_.find(packVoxel(i, j, 0));
        if (number == VoxelIndex::kAbsent) continue;
        for (std::uint32_t k = begin_[number]; k < begin_[number + 1]; ++k) visit(members_[k]);
      }
  }
  /// Points of one cell, by the cells' numbers in order of appearance.
  std::size_t cells() const { return index_.size(); }
  std::span<const std::uint32_t> members(std::size_t number) const {
    return {members_.data() + begin_[number], begin_[number + 1] - begin_[number]};
  }

 private:
  std::int32_t cell(float value) const { return floorToInt(value * per_cell_); }

  float per_cell_ = 1;
  VoxelIndex index_;
  std::vector<std::uint32_t> begin_, members_;
};

}  // namespace scslam::radar_surface
