#include "scslam/core/voxel_filter.h"

#include <algorithm>
#include <bit>

#include "scslam/core/simd.h"
#include "scslam/core/voxel_index.h"

namespace scslam {
namespace {

struct RangeLimits {
  float min2, max2;  // squared [m^2]
};

/// Keys of n points; kNoVoxel for those outside the limits (a NaN compares false and is outside).
SCSLAM_KERNEL
void voxelKeys(const float* x, const float* y, const float* z, std::size_t n, float inverse_size, RangeLimits range,
               VoxelKey* keys) {
  for (std::size_t i = 0; i < n; ++i) {
    const float range2 = x[i] * x[i] + y[i] * y[i] + z[i] * z[i];
    const bool inside = range2 >= range.min2 && range2 <= range.max2;
    const float px = inside ? x[i] : 0.0f, py = inside ? y[i] : 0.0f, pz = inside ? z[i] : 0.0f;
    const VoxelKey key =
        packVoxel(floorToInt(px * inverse_size), floorToInt(py * inverse_size), floorToInt(pz * inverse_size));
    keys[i] = inside ? key : kNoVoxel;
  }
}

constexpr std::size_t kBlock = 256;

/// Drawn once for every place in a cloud; no two places have the same.
std::uint32_t lot(std::uint32_t i) {
  i *= 0x9E3779B1u;
  i ^= i >> 15;
  return i * 0x85EBCA77u;
}

/// Calls visit(i, key) for the points within the limits, in order.
template <class Visit>
void forEachKey(const Cloud& cloud, double voxel_m, double min_range_m, double max_range_m, const Visit& visit) {
  VoxelKey keys[kBlock];
  const RangeLimits range{static_cast<float>(min_range_m * min_range_m), static_cast<float>(max_range_m * max_range_m)};
  for (std::size_t begin = 0; begin < cloud.size(); begin += kBlock) {
    const std::size_t n = std::min(kBlock, cloud.size() - begin);
    voxelKeys(&cloud.x[begin], &cloud.y[begin], &cloud.z[begin], n, static_cast<float>(1.0 / voxel_m), range, keys);
    for (std::size_t i = 0; i < n; ++i)
      if (keys[i] != kNoVoxel) visit(begin + i, keys[i]);
  }
}

/// Different numbers below n, sorted.
std::vector<std::uint32_t> increasing(const std::vector<std::uint32_t>& numbers, std::size_t n) {
  std::vector<std::uint64_t> bits((n + 63) / 64);
  for (const std::uint32_t number : numbers) bits[number / 64] |= std::uint64_t{1} << (number % 64);
  std::vector<std::uint32_t> sorted;
  sorted.reserve(numbers.size());
  for (std::size_t word = 0; word < bits.size(); ++word)
    for (std::uint64_t left = bits[word]; left != 0; left &= left - 1)
      sorted.push_back(static_cast<std::uint32_t>(64 * word) + static_cast<std::uint32_t>(std::countr_zero(left)));
  return sorted;
}

}  // namespace

std::vector<std::uint32_t> onePerVoxel(const Cloud& cloud, double voxel_m, double min_range_m, double max_range_m) {
  VoxelIndex voxels(cloud.size() / 8);
  std::vector<std::uint32_t> chosen;  // by voxel
  chosen.reserve(cloud.size() / 4);
  // Neighbours in a scan often share a voxel: the best of such a run is known before its voxel is looked up.
  VoxelKey key_of_run = kNoVoxel;
  std::uint32_t best = 0, best_lot = 0;
  const auto endRun = [&] {
    if (key_of_run == kNoVoxel) return;
    const std::uint32_t voxel = voxels.findOrInsert(key_of_run);
    if (voxel == chosen.size())
      chosen.push_back(best);
    else if (best_lot < lot(chosen[voxel]))
      chosen[voxel] = best;
  };
  forEachKey(cloud, voxel_m, min_range_m, max_range_m, [&](std::size_t at, VoxelKey key) {
    const auto i = static_cast<std::uint32_t>(at);
    const std::uint32_t lot_of_i = lot(i);
    if (key == key_of_run && lot_of_i >= best_lot) return;
    if (key != key_of_run) endRun();
    key_of_run = key, best = i, best_lot = lot_of_i;
  });
  endRun();
  return increasing(chosen, cloud.size());
}

Cloud centroidPerVoxel(const Cloud& cloud, double voxel_m) {
  VoxelIndex voxels(cloud.size() / 8);
  std::vector<Eigen::Vector4d> sums;
  forEachKey(cloud, voxel_m, 0.0, 1e4, [&](std::size_t i, VoxelKey key) {
    const std::uint32_t voxel = voxels.findOrInsert(key);
    if (voxel == sums.size()) sums.push_back(Eigen::Vector4d::Zero());
    sums[voxel] += Eigen::Vector4d(cloud.x[i], cloud.y[i], cloud.z[i], 1.0);
  });
  Cloud result;
  result.reserve(sums.size());
  for (const Eigen::Vector4d& sum : sums) {
    const Eigen::Vector3f mean = (sum.head<3>() / sum.w()).cast<float>();
    result.push(mean.x(), mean.y(), mean.z());
  }
  return result;
}

Cloud selected(const Cloud& cloud, const std::vector<std::uint32_t>& points) {
  Cloud result;
  result.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    result.x[i] = cloud.x[points[i]];
    result.y[i] = cloud.y[points[i]];
    result.z[i] = cloud.z[points[i]];
  }
  return result;
}

}  // namespace scslam
