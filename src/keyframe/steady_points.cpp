#include "scslam/keyframe/steady_points.h"

#include <algorithm>
#include <bit>

namespace scslam {

SteadyPoints::SteadyPoints(const std::vector<Cloud>& scans, double near_m, bool planar)
    : scans_(scans), inverse_size_(static_cast<float>(1 / near_m)), planar_(planar) {
  constexpr std::size_t kBits = 64;
  const std::size_t shared = std::max<std::size_t>(1, (scans.size() + kBits - 1) / kBits);
  for (std::size_t number = 0; number < scans.size(); ++number) {
    const std::uint64_t bit = std::uint64_t{1} << (number / shared);
    for (std::size_t i = 0; i < scans[number].size(); ++i) {
      const std::uint32_t cell = index_.findOrInsert(packVoxel(cellOf(scans[number].point(i))));
      if (cell == seen_by_.size()) seen_by_.push_back(0);
      seen_by_[cell] |= bit;
    }
  }
}

VoxelCoord SteadyPoints::cellOf(const Eigen::Vector3f& p) const {
  return {floorToInt(p.x() * inverse_size_), floorToInt(p.y() * inverse_size_),
          planar_ ? 0 : floorToInt(p.z() * inverse_size_)};
}

std::uint64_t SteadyPoints::scansAround(const Eigen::Vector3f& p) const {
  const VoxelCoord centre = cellOf(p);
  const int up = planar_ ? 0 : 1;
  std::uint64_t scans = 0;
  for (int dz = -up; dz <= up; ++dz)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const std::uint32_t cell = index_.find(packVoxel(centre + VoxelCoord(dx, dy, dz)));
        if (cell != VoxelIndex::kAbsent) scans |= seen_by_[cell];
      }
  return scans;
}

Cloud SteadyPoints::of(std::size_t number, int scans) const {
  Cloud steady;
  const Cloud& scan = scans_[number];
  for (std::size_t i = 0; i < scan.size(); ++i)
    if (std::popcount(scansAround(scan.point(i))) >= scans) steady.push(scan.x[i], scan.y[i], scan.z[i]);
  return steady;
}

}  // namespace scslam
