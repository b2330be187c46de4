#include "scslam/place/context_image.h"

#include <cmath>

#include "scslam/core/simd.h"
#include "scslam/place/float8.h"

namespace scslam {
namespace {

using Bins = std::int32_t[UprightBlock::kSize];

struct PolarScale {
  float max_radius2, per_metre, per_radian;
  std::int32_t rings, sectors, outside;
};

/// Bin of every point, `outside` where it has none (NaN included). Arc tangent by a polynomial, exact to 1e-5 rad;
/// square root by Newton's iteration.
SCSLAM_KERNEL void polarBins(const UprightBlock& b, const PolarScale& s, Bins& bins) {
  constexpr auto kPi = static_cast<float>(M_PI);
  const Float8 zero = {};
  for (std::size_t i = 0; i < UprightBlock::kSize; i += kLanes) {
    Float8 x, y;
    load8(x, b.x + i), load8(y, b.y + i);
    const Float8 ax = x < zero ? -x : x, ay = y < zero ? -y : y;
    const Float8 t = (ax > ay ? ay : ax) / (ax > ay ? ax : ay), t2 = t * t;
    Float8 a = 0.05265332f - t2 * 0.01172120f;
    a = t * (0.99997726f + t2 * (-0.33262347f + t2 * (0.19354346f + t2 * (-0.11643287f + t2 * a))));
    a = ay > ax ? 0.5f * kPi - a : a;
    a = x < zero ? kPi - a : a;
    a = y < zero ? 2 * kPi - a : a;
    const Float8 r2 = x * x + y * y;
    const Int8 inside = (r2 > 1e-6f) & (r2 < s.max_radius2);
    Int8 bits;
    std::memcpy(&bits, &r2, sizeof bits);
    bits = 0x5f3759df - (bits >> 1);  // reciprocal square root to 3 %, then three times twice the digits
    Float8 q;
    std::memcpy(&q, &bits, sizeof q);
    for (int iteration = 0; iteration < 3; ++iteration) q = q * (1.5f - 0.5f * r2 * q * q);
    Int8 ring = __builtin_convertvector(inside ? r2 * q * s.per_metre : zero, Int8);
    Int8 sector = __builtin_convertvector(inside ? a * s.per_radian : zero, Int8);
    ring = ring < s.rings ? ring : ring * 0 + (s.rings - 1);
    sector = sector < s.sectors ? sector : sector * 0 + (s.sectors - 1);
    const Int8 bin = inside ? ring * s.sectors + sector : ring * 0 + s.outside;
    std::memcpy(bins + i, &bin, sizeof bin);
  }
}

struct CartScale {
  float reach_x, reach_y, per_metre_x, per_metre_y;
  std::int32_t rows, columns, outside;
};

SCSLAM_KERNEL void cartBins(const UprightBlock& b, const CartScale& s, Bins& bins) {
  const Float8 zero = {};
  for (std::size_t i = 0; i < UprightBlock::kSize; i += kLanes) {
    Float8 x, y;
    load8(x, b.x + i), load8(y, b.y + i);
    x += s.reach_x, y += s.reach_y;
    const Int8 inside = (x >= zero) & (x < 2 * s.reach_x) & (y >= zero) & (y < 2 * s.reach_y);
    Int8 row = __builtin_convertvector(inside ? x * s.per_metre_x : zero, Int8);
    Int8 column = __builtin_convertvector(inside ? y * s.per_metre_y : zero, Int8);
    row = row < s.rows ? row : row * 0 + (s.rows - 1);
    column = column < s.columns ? column : column * 0 + (s.columns - 1);
    const Int8 bin = inside ? row * s.columns + column : row * 0 + s.outside;
    std::memcpy(bins + i, &bin, sizeof bin);
  }
}

/// The highest point of every bin. `binsOf(block, bins)` gives rows * columns for points outside.
template <class BinsOf>
Descriptor highest(const Cloud& cloud, const Upright& upright, float left_m, Eigen::Index rows, Eigen::Index columns,
                   BinsOf&& binsOf) {
  std::vector<float> image(static_cast<std::size_t>(rows * columns) + 1, 0.0f);  // the last one takes what is outside
  UprightBlock block;
  Bins bins;
  for (std::size_t begin = 0; begin < cloud.size(); begin += UprightBlock::kSize) {
    uprightBlock(cloud, upright, begin, left_m, block);
    binsOf(block, bins);
    for (std::size_t i = 0; i < block.count; ++i) {
      float& top = image[static_cast<std::size_t>(bins[i])];
      top = block.height[i] > top ? block.height[i] : top;
    }
  }
  return Eigen::Map<const Descriptor>(image.data(), rows, columns);
}

}  // namespace

Descriptor polarContext(const Cloud& cloud_base, const Upright& upright, const PolarGrid& grid, double left_m) {
  const auto radius = static_cast<float>(grid.max_radius_m);
  const PolarScale scale{radius * radius,
                         static_cast<float>(grid.rings / grid.max_radius_m),
                         static_cast<float>(grid.sectors / (2 * M_PI)),
                         grid.rings,
                         grid.sectors,
                         grid.rings * grid.sectors};
  return highest(cloud_base, upright, static_cast<float>(left_m), grid.rings, grid.sectors,
                 [&scale](const UprightBlock& block, Bins& bins) { polarBins(block, scale, bins); });
}

Descriptor polarContext(const Descriptor& polar, const PolarGrid& grid, double left_m) {
  constexpr int kSpread = 4;  // points per bin in each direction
  Cloud points;
  for (int ring = 0; ring < grid.rings; ++ring)
    for (int sector = 0; sector < grid.sectors; ++sector) {
      const float height = polar(ring, sector);
      if (!(height > 0)) continue;
      for (int a = 0; a < kSpread; ++a)
        for (int b = 0; b < kSpread; ++b) {
          const double range = (ring + (a + 0.5) / kSpread) * grid.max_radius_m / grid.rings;
          const double azimuth = (sector + (b + 0.5) / kSpread) * 2 * M_PI / grid.sectors;
          points.push(static_cast<float>(range * std::cos(azimuth)), static_cast<float>(range * std::sin(azimuth)),
                      height);
        }
    }
  return polarContext(points, Upright(), grid, left_m);
}

Descriptor cartContext(const Cloud& cloud_base, const Upright& upright, const CartGrid& grid) {
  const CartScale scale{static_cast<float>(grid.reach_ahead_m),
                        static_cast<float>(grid.reach_aside_m),
                        static_cast<float>(grid.rows / (2 * grid.reach_ahead_m)),
                        static_cast<float>(grid.columns / (2 * grid.reach_aside_m)),
                        grid.rows,
                        grid.columns,
                        grid.rows * grid.columns};
  return highest(cloud_base, upright, 0, grid.rows, grid.columns,
                 [&scale](const UprightBlock& block, Bins& bins) { cartBins(block, scale, bins); });
}

}  // namespace scslam
