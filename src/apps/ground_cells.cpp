#include "scslam/apps/ground_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace scslam {
namespace {

constexpr float kCell_m = GroundCells::kCell_m;
/// Of the lowest points that the scans have of a cell this quantile is the ground: the very lowest are errors of range.
constexpr double kQuantile = 0.25;
/// The ground rises by no more than this towards a cell from those around it; what seems to hid it.
constexpr float kSlope = 0.3F;
constexpr std::int32_t kAround = 4;  ///< cells

VoxelKey cellOf(const Eigen::Vector3f& p, std::int32_t dx = 0, std::int32_t dy = 0) {
  return packVoxel(floorToInt(p.x() / kCell_m) + dx, floorToInt(p.y() / kCell_m) + dy, 0);
}

}  // namespace

std::vector<LowPoint> lowPoints(const Cloud& cloud_map, const Eigen::Vector3f& sensor_map, float reach_m) {
  VoxelIndex index;
  std::vector<float> lowest;
  for (std::size_t i = 0; i < cloud_map.size(); ++i) {
    const Eigen::Vector3f p = cloud_map.point(i);
    if (!p.allFinite() || (p - sensor_map).head<2>().norm() > reach_m) continue;
    const std::uint32_t cell = index.findOrInsert(cellOf(p));
    if (cell == lowest.size()) lowest.push_back(p.z());
    lowest[cell] = std::min(lowest[cell], p.z());
  }
  std::vector<LowPoint> points;
  for (std::size_t cell = 0; cell < lowest.size(); ++cell) points.push_back({index.keys()[cell], lowest[cell]});
  return points;
}

GroundCells::GroundCells(const std::vector<const std::vector<LowPoint>*>& scans) {
  std::vector<std::vector<float>> heights;
  for (const std::vector<LowPoint>* points : scans)
    for (const LowPoint& point : *points) {
      const std::uint32_t cell = index_.findOrInsert(point.cell);
      if (cell == heights.size()) heights.emplace_back();
      heights[cell].push_back(point.z);
    }
  for (std::vector<float>& cell : heights) {
    const auto at = cell.begin() + static_cast<std::ptrdiff_t>(kQuantile * static_cast<double>(cell.size() - 1));
    std::nth_element(cell.begin(), at, cell.end());
    z_.push_back(*at);
  }
  const std::vector<float> seen = z_;
  for (std::uint32_t cell = 0; cell < z_.size(); ++cell) {
    const VoxelCoord at = unpackVoxel(index_.keys()[cell]);
    for (std::int32_t dy = -kAround; dy <= kAround; ++dy)
      for (std::int32_t dx = -kAround; dx <= kAround; ++dx) {
        const std::uint32_t other = index_.find(packVoxel(at + VoxelCoord(dx, dy, 0)));
        if (other == VoxelIndex::kAbsent) continue;
        const float away_m = kCell_m * std::hypot(static_cast<float>(dx), static_cast<float>(dy));
        z_[cell] = std::min(z_[cell], seen[other] + kSlope * away_m);
      }
  }
}

float GroundCells::heightOf(const Eigen::Vector3f& p_map) const {
  if (const std::uint32_t own = index_.find(cellOf(p_map)); own != VoxelIndex::kAbsent) return p_map.z() - z_[own];
  float ground = std::numeric_limits<float>::infinity();
  for (std::int32_t dy = -1; dy <= 1; ++dy)
    for (std::int32_t dx = -1; dx <= 1; ++dx)
      if (const std::uint32_t cell = index_.find(cellOf(p_map, dx, dy)); cell != VoxelIndex::kAbsent)
        ground = std::min(ground, z_[cell]);
  return std::isfinite(ground) ? p_map.z() - ground : std::numeric_limits<float>::infinity();
}

}  // namespace scslam
