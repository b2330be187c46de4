// Integer voxel coordinates packed into one 64-bit word, 21 bits an axis (+-1,048,576 voxels).
#pragma once
#include <cmath>
#include <cstdint>

#include "scslam/core/pose.h"

namespace scslam {

using VoxelKey = std::uint64_t;
using VoxelCoord = Eigen::Vector3i;

/// Never the key of a voxel: bit 63 is set.
inline constexpr VoxelKey kNoVoxel = ~VoxelKey{0};

/// Coordinates beyond +-2^20 wrap around; at 0.1 m voxels that is 105 km from the origin.
inline VoxelKey packVoxel(std::int32_t x, std::int32_t y, std::int32_t z) {
  constexpr std::int32_t kOffset = 1 << 20;
  constexpr VoxelKey kMask = (VoxelKey{1} << 21) - 1;
  const auto field = [](std::int32_t v) {
    return static_cast<VoxelKey>(static_cast<std::uint32_t>(v + kOffset)) & kMask;
  };
  return field(x) | (field(y) << 21) | (field(z) << 42);
}
inline VoxelKey packVoxel(const VoxelCoord& v) { return packVoxel(v.x(), v.y(), v.z()); }

inline VoxelCoord unpackVoxel(VoxelKey key) {
  constexpr std::int32_t kOffset = 1 << 20;
  constexpr VoxelKey kMask = (VoxelKey{1} << 21) - 1;
  const auto coordinate = [key](int shift) { return static_cast<std::int32_t>((key >> shift) & kMask) - kOffset; };
  return {coordinate(0), coordinate(21), coordinate(42)};
}

/// floor() that vectorises without SSE4.1. Beyond +-1e9, and for NaN, the bound: no such voxel is ever filled.
inline std::int32_t floorToInt(float value) {
  const float below = value < 1e9f ? value : 1e9f;  // NaN compares false
  const float bounded = below > -1e9f ? below : -1e9f;
  const auto truncated = static_cast<std::int32_t>(bounded);
  return truncated - (bounded < static_cast<float>(truncated) ? 1 : 0);
}

}  // namespace scslam
