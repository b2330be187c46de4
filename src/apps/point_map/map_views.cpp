#include "scslam/apps/point_map/map_views.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace scslam {
namespace {

constexpr float kPi = static_cast<float>(M_PI);
constexpr float kSquare_m = 10;
constexpr float kNearest_m = 0.5F;
constexpr float kFar = std::numeric_limits<float>::max();

/// Directions in cells of azimuth and elevation.
struct Directions {
  int columns, rows;
  std::size_t cells() const { return static_cast<std::size_t>(columns * rows); }
  std::size_t of(const Eigen::Vector3f& d) const {
    const auto bin = [](float angle, float whole, int n) {
      return std::clamp(static_cast<int>(angle / whole * static_cast<float>(n)), 0, n - 1);
    };
    const int column = bin(std::atan2(d.y(), d.x()) + kPi, 2 * kPi, columns);
    const int row = bin(std::atan2(d.z(), std::hypot(d.x(), d.y())) + kPi / 2, kPi, rows);
    return static_cast<std::size_t>(row * columns + column);
  }
};

constexpr Directions kCoarse{360, 180};  ///< what is nearest in a cell hides what lies behind: no gap between points of
                                         ///< a wall near by is wider
constexpr Directions kFine{1440, 450};
/// A surface seen askance goes back within its cell.
constexpr float kDepth = 0.06F, kDepth_m = 0.3F;

}  // namespace

MapViews::MapViews(Cloud cloud_map, double range_m)
    : cloud_(std::move(cloud_map)), range_m_(static_cast<float>(range_m)) {
  for (std::uint32_t i = 0; i < cloud_.size(); ++i) {
    if (!cloud_.point(i).allFinite()) continue;
    const std::uint32_t square =
        squares_.findOrInsert(packVoxel(floorToInt(cloud_.x[i] / kSquare_m), floorToInt(cloud_.y[i] / kSquare_m), 0));
    if (square == by_square_.size()) by_square_.emplace_back();
    by_square_[square].push_back(i);
  }
}

std::vector<std::uint32_t> MapViews::around(const Eigen::Vector3f& viewpoint_map) const {
  std::vector<std::uint32_t> points;
  const std::int32_t x = floorToInt(viewpoint_map.x() / kSquare_m), y = floorToInt(viewpoint_map.y() / kSquare_m);
  const auto reach = static_cast<std::int32_t>(std::ceil(range_m_ / kSquare_m));
  for (std::int32_t dy = -reach; dy <= reach; ++dy)
    for (std::int32_t dx = -reach; dx <= reach; ++dx)
      if (const std::uint32_t square = squares_.find(packVoxel(x + dx, y + dy, 0)); square != VoxelIndex::kAbsent)
        points.insert(points.end(), by_square_[square].begin(), by_square_[square].end());
  return points;
}

Cloud MapViews::from(const Eigen::Vector3f& viewpoint_map) const {
  struct Ray {
    std::uint32_t point;
    std::size_t coarse;
    float range;
  };
  std::vector<Ray> rays;
  std::vector<float> nearest(kCoarse.cells(), kFar);
  for (const std::uint32_t i : around(viewpoint_map)) {
    const Eigen::Vector3f d = cloud_.point(i) - viewpoint_map;
    const float range = d.norm();
    if (range < kNearest_m || range > range_m_) continue;
    const std::size_t cell = kCoarse.of(d);
    rays.push_back({i, cell, range});
    nearest[cell] = std::min(nearest[cell], range);
  }
  std::vector<std::uint32_t> seen(kFine.cells(), VoxelIndex::kAbsent);
  std::vector<float> seen_range(kFine.cells(), kFar);
  for (const Ray& ray : rays) {
    if (ray.range > nearest[ray.coarse] * (1 + kDepth) + kDepth_m) continue;
    const std::size_t cell = kFine.of(cloud_.point(ray.point) - viewpoint_map);
    if (ray.range < seen_range[cell]) seen_range[cell] = ray.range, seen[cell] = ray.point;
  }
  Cloud view;
  for (const std::uint32_t i : seen) {
    if (i == VoxelIndex::kAbsent) continue;
    const Eigen::Vector3f d = cloud_.point(i) - viewpoint_map;
    view.push(d.x(), d.y(), d.z());
    if (cloud_.hasIntensity()) view.intensity.push_back(cloud_.intensity[i]);
  }
  return view;
}

}  // namespace scslam
