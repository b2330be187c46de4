#include "scslam/apps/clean/objects.h"

#include <cmath>

#include "scslam/core/voxel_index.h"

namespace scslam {
namespace {

constexpr float kNear_m = 15;  ///< up to here cells are equally wide

/// p pulled towards the sensor so that cells of 1 there are gap_m wide near by and gap_m * range / kNear_m beyond.
Eigen::Vector3f warped(const Eigen::Vector3f& p, float gap_m) {
  const float range = p.norm();
  if (range <= kNear_m) return p / gap_m;
  return p * ((kNear_m + kNear_m * std::log(range / kNear_m)) / (range * gap_m));
}

}  // namespace

ScanCells::ScanCells(const Cloud& cloud_sensor, const std::vector<std::uint8_t>& of, double gap_m)
    : cell_(cloud_sensor.size(), kNone) {
  VoxelIndex index(cloud_sensor.size() / 8);
  for (std::size_t i = 0; i < cloud_sensor.size(); ++i) {
    const Eigen::Vector3f p = cloud_sensor.point(i);
    if (of[i] == 0 || !p.allFinite()) continue;
    const Eigen::Vector3f w = warped(p, static_cast<float>(gap_m));
    cell_[i] = index.findOrInsert(packVoxel(floorToInt(w.x()), floorToInt(w.y()), floorToInt(w.z())));
  }
  neighbours_.resize(index.size());
  for (std::uint32_t cell = 0; cell < index.size(); ++cell) {
    const VoxelCoord at = unpackVoxel(index.keys()[cell]);
    for (int d = 0; d < 27; ++d) {
      const VoxelCoord beside = at + VoxelCoord(d % 3 - 1, d / 3 % 3 - 1, d / 9 - 1);
      const std::uint32_t other = index.find(packVoxel(beside));
      if (other != VoxelIndex::kAbsent && other != cell) neighbours_[cell].push_back(other);
    }
  }
}

std::vector<std::uint32_t> ScanCells::groups(const std::vector<std::uint8_t>& of, std::size_t& groups) const {
  std::vector<std::uint32_t> group(size(), kNone), reached;
  groups = 0;
  for (std::uint32_t first = 0; first < size(); ++first) {
    if (of[first] == 0 || group[first] != kNone) continue;
    group[first] = static_cast<std::uint32_t>(groups);
    reached.assign(1, first);
    while (!reached.empty()) {
      const std::uint32_t cell = reached.back();
      reached.pop_back();
      for (const std::uint32_t other : neighbours_[cell]) {
        if (of[other] == 0 || group[other] != kNone) continue;
        group[other] = static_cast<std::uint32_t>(groups);
        reached.push_back(other);
      }
    }
    ++groups;
  }
  return group;
}

}  // namespace scslam
