#include "scslam/place/context_image.h"

#include <cmath>

#include "scslam/core/simd.h"

namespace scslam {
namespace {

using Bins = std::int32_t[UprightBlock::kSize];

struct PolarScale {
  float max_radius2, per_metre, per_radian;
  std::int32_t rings, sectors, outside;
};

/// Bin of every point, `outside` where it has none (NaN included). The arc tangent is a polynomial, exact to 1e-5 rad.
SCSLAM_KERNEL void polarBins(const UprightBlock& b, const PolarScale& s, Bins& bins) {
  constexpr auto kPi = static_cast<float>(M_PI);
  for (std::size_t i = 0; i < UprightBlock::kSize; ++i) {
    const float x = b.x[i], y = b.y[i];
    const float ax = x < 0 ? -x : x, ay = y < 0 ? -y : y;
    const float larger = ax > ay ? ax : ay, smaller = ax > ay ? ay : ax;
    const float r2 = x * x + y * y;
    const float t = smaller / larger, t2 = t * t;
    float a =
        t * (0.99997726f +
             t2 * (-0.33262347f + t2 * (0.19354346f + t2 * (-0.11643287f + t2 * (0.05265332f - t2 * 0.01172120f)))));
    a = ay > ax ? 0.5f * kPi - a : a;
    a = x < 0 ? kPi - a : a;
    a = y < 0 ? 2 * kPi - a : a;
    const bool inside = (r2 > 1e-6f) & (r2 < s.max_radius2);
    const float ring_at = inside ? std::sqrt(r2) * s.per_metre : 0.0f, sector_at = inside ? a * s.per_radian : 0.0f;
    auto ring = static_cast<std::int32_t>(ring_at), sector = static_cast<std::int32_t>(sector_at);
    ring = ring < s.rings ? ring : s.rings - 1;
    sector = sector < s.sectors ? sector : s.sectors - 1;
    bins[i] = inside ? ring * s.sectors + sector : s.outside;
  }
}

struct CartScale {
  float reach_x, reach_y, per_metre_x, per_metre_y;
  std::int32_t rows, columns, outside;
};

SCSLAM_KERNEL void cartBins(const UprightBlock& b, const CartScale& s, Bins& bins) {
  for (std::size_t i = 0; i < UprightBlock::kSize; ++i) {
    const float x = b.x[i] + s.reach_x, y = b.y[i] + s.reach_y;
    const bool inside = (x >= 0) & (x < 2 * s.reach_x) & (y >= 0) & (y < 2 * s.reach_y);
    const float row_at = inside ? x * s.per_metre_x : 0.0f, column_at = inside ? y * s.per_metre_y : 0.0f;
    auto row = static_cast<std::int32_t>(row_at), column = static_cast<std::int32_t>(column_at);
    row = row < s.rows ? row : s.rows - 1;
    column = column < s.columns ? column : s.columns - 1;
    bins[i] = inside ? row * s.columns + column : s.outside;
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
