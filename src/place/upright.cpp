#include "scslam/place/upright.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scslam/core/gravity.h"
#include "scslam/core/simd.h"
#include "scslam/place/float8.h"

namespace scslam {
namespace {

constexpr std::size_t kGroundPoints = 8000;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

SCSLAM_KERNEL void turn(const float* px, const float* py, const float* pz, const float* R, float left, float ground,
                        UprightBlock& b) {
  for (std::size_t i = 0; i < UprightBlock::kSize; i += kLanes) {
    Float8 x, y, z;
    load8(x, px + i), load8(y, py + i), load8(z, pz + i);
    store8(b.x + i, R[0] * x + R[1] * y + R[2] * z);
    store8(b.y + i, R[3] * x + R[4] * y + R[5] * z - left);
    store8(b.height + i, R[6] * x + R[7] * y + R[8] * z - ground);
  }
}

}  // namespace

Upright uprightOf(const Keyframe& keyframe, const Cloud& cloud_base) {
  Upright upright;
  const Eigen::Matrix3d R = levelling(keyframe.T_odom_base);
  upright.R_level_base = R.cast<float>();
  upright.planar = keyframe.planar;
  if (keyframe.planar) return upright;
  const std::size_t stride = std::max<std::size_t>(1, cloud_base.size() / kGroundPoints);
  Cloud sample;
  sample.reserve(cloud_base.size() / stride + 1);
  for (std::size_t i = 0; i < cloud_base.size(); i += stride)
    sample.push(cloud_base.x[i], cloud_base.y[i], cloud_base.z[i]);
  Pose T_level_base = Pose::Identity();
  T_level_base.linear() = R;
  transformInPlace(sample, T_level_base);
  upright.ground_m = static_cast<float>(groundHeight(sample));
  return upright;
}

void uprightBlock(const Cloud& cloud_base, const Upright& upright, std::size_t begin, float left_m,
                  UprightBlock& block) {
  const Eigen::Matrix<float, 3, 3, Eigen::RowMajor> R = upright.R_level_base;
  block.count = std::min(UprightBlock::kSize, cloud_base.size() - begin);
  if (block.count == UprightBlock::kSize) {
    turn(&cloud_base.x[begin], &cloud_base.y[begin], &cloud_base.z[begin], R.data(), left_m, upright.ground_m, block);
  } else {
    alignas(32) float padded[3][UprightBlock::kSize];
    std::fill_n(&padded[0][0], 3 * UprightBlock::kSize, kNan);
    const auto from = static_cast<std::ptrdiff_t>(begin);
    std::copy(cloud_base.x.begin() + from, cloud_base.x.end(), padded[0]);
    std::copy(cloud_base.y.begin() + from, cloud_base.y.end(), padded[1]);
    std::copy(cloud_base.z.begin() + from, cloud_base.z.end(), padded[2]);
    turn(padded[0], padded[1], padded[2], R.data(), left_m, upright.ground_m, block);
  }
  if (upright.planar) std::fill_n(block.height, block.count, 1.0f);
}

Cloud outline(const Cloud& cloud_base, const Upright& upright, double cell_m, double radius_m) {
  const auto side = static_cast<int>(std::ceil(2 * radius_m / cell_m));
  const auto scale = static_cast<float>(1 / cell_m), radius = static_cast<float>(radius_m);
  const auto cells = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
  std::vector<std::int32_t> slot(cells, -1);  // where the cell's highest point stands in the result
  Cloud highest;
  UprightBlock block;
  for (std::size_t begin = 0; begin < cloud_base.size(); begin += UprightBlock::kSize) {
    uprightBlock(cloud_base, upright, begin, 0, block);
    for (std::size_t i = 0; i < block.count; ++i) {
      const float x = block.x[i], y = block.y[i], height = block.height[i];
      if (!(std::abs(x) < radius && std::abs(y) < radius && height > 0)) continue;
      const int column = std::min(static_cast<int>((x + radius) * scale), side - 1);
      const int row = std::min(static_cast<int>((y + radius) * scale), side - 1);
      std::int32_t& at =
          slot[static_cast<std::size_t>(row) * static_cast<std::size_t>(side) + static_cast<std::size_t>(column)];
      if (at < 0) {
        at = static_cast<std::int32_t>(highest.size());
        highest.push(x, y, height);
      } else if (const auto k = static_cast<std::size_t>(at); height > highest.z[k]) {
        highest.x[k] = x, highest.y[k] = y, highest.z[k] = height;
      }
    }
  }
  return highest;
}

}  // namespace scslam
