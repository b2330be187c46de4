#include "scslam/apps/clean/sight_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "scslam/core/simd.h"

namespace scslam {
namespace {

constexpr float kPi = static_cast<float>(M_PI);
constexpr float kNearest_m = 0.3F;  ///< nearer returns are no measurements
constexpr float kSky = std::numeric_limits<float>::max();
constexpr std::size_t kBlock = 512;
constexpr std::int32_t kOutside = -1;

float elevationOf(const Eigen::Vector3f& p) { return std::atan2(p.z(), std::hypot(p.x(), p.y())); }
bool isReturn(const Eigen::Vector3f& p) { return p.allFinite() && p.norm() >= kNearest_m; }

/// How far the beams lie apart in elevation: the median gap between the elevations in narrow sectors of azimuth. Points
/// of one beam lie closer than kSame_rad there.
float beamSpacing(const std::vector<Cloud>& samples) {
  constexpr float kSame_rad = 0.12F * kPi / 180;
  constexpr int kSectors = 90, kDivisions = 8;  // of each sector one part in eight is looked at
  std::vector<float> gaps;
  for (const Cloud& cloud : samples) {
    std::vector<std::vector<float>> sectors(kSectors);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Eigen::Vector3f p = cloud.point(i);
      if (!isReturn(p)) continue;
      const auto part = static_cast<int>((std::atan2(p.y(), p.x()) + kPi) / (2 * kPi) * (kSectors * kDivisions));
      if (part % kDivisions == 0)
        sectors[static_cast<std::size_t>(part / kDivisions % kSectors)].push_back(elevationOf(p));
    }
    for (std::vector<float>& sector : sectors) {
      std::sort(sector.begin(), sector.end());
      for (std::size_t i = 1; i < sector.size(); ++i)
        if (const float gap = sector[i] - sector[i - 1]; gap > kSame_rad) gaps.push_back(gap);
    }
  }
  if (gaps.empty()) return kPi / 180;
  std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2), gaps.end());
  return gaps[gaps.size() / 2];
}

/// atan2(y, x) to 2e-5 rad; no branches, so that loops over it become vector code.
inline float fastAtan2(float y, float x) {
  const float ax = std::abs(x), ay = std::abs(y);
  const float low = ax < ay ? ax : ay, high = ax < ay ? ay : ax;
  const float t = low / (high > 1e-20F ? high : 1e-20F), t2 = t * t;
  float angle = t * (0.9998660F + t2 * (-0.3302995F + t2 * (0.1801410F + t2 * (-0.0851330F + t2 * 0.0208351F))));
  angle = ax < ay ? kPi / 2 - angle : angle;
  angle = x < 0 ? kPi - angle : angle;
  return y < 0 ? -angle : angle;
}

struct Projection {
  std::array<float, 12> T;  ///< row-major 3x4
  float columns_per_rad, rows_per_rad, lowest_rad, last_row;
  std::int32_t columns;
  float level;  ///< 0: elevations do not count
};

/// Range and corner number of each point; kOutside where the sensor does not look.
SCSLAM_KERNEL void project(const float* x, const float* y, const float* z, std::size_t n, const Projection& to,
                           float* range, std::int32_t* corner) {
  const std::array<float, 12> T = to.T;
  for (std::size_t i = 0; i < n; ++i) {
    const float px = T[0] * x[i] + T[1] * y[i] + T[2] * z[i] + T[3];
    const float py = T[4] * x[i] + T[5] * y[i] + T[6] * z[i] + T[7];
    const float pz = (T[8] * x[i] + T[9] * y[i] + T[10] * z[i] + T[11]) * to.level;
    const float flat2 = px * px + py * py;
    range[i] = std::sqrt(flat2 + pz * pz);
    const float u = (fastAtan2(py, px) + kPi) * to.columns_per_rad + 0.5F;
    const float v = (fastAtan2(pz, std::sqrt(flat2)) - to.lowest_rad) * to.rows_per_rad + 0.5F;
    const bool inside = v >= 0 && v < to.last_row + 1;  // false for NaN
    const auto column = static_cast<std::int32_t>(inside ? u : 0);
    const auto row = static_cast<std::int32_t>(inside ? v : 0);
    const std::int32_t wrapped = column >= to.columns ? column - to.columns : column;
    corner[i] = inside ? row * to.columns + wrapped : kOutside;
  }
}

/// Nearest and farthest return of each cell; farthest < 0: none.
struct CellRanges {
  std::vector<float> nearest, farthest;
};

CellRanges cellRanges(const Cloud& cloud, const SightGrid& grid) {
  CellRanges cells{std::vector<float>(grid.rows * grid.columns, kSky),
                   std::vector<float>(grid.rows * grid.columns, -1)};
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Eigen::Vector3f p = cloud.point(i);
    if (!isReturn(p)) continue;
    if (grid.planar) p.z() = 0;
    const float u = (fastAtan2(p.y(), p.x()) + kPi) / grid.column_rad;
    const float v = (fastAtan2(p.z(), std::hypot(p.x(), p.y())) - grid.lowest_rad) / grid.row_rad;
    if (v < 0 || v >= static_cast<float>(grid.rows)) continue;
    const std::size_t cell =
        grid.at(static_cast<std::size_t>(v), std::min(static_cast<std::size_t>(u), grid.columns - 1));
    cells.nearest[cell] = std::min(cells.nearest[cell], p.norm());
    cells.farthest[cell] = std::max(cells.farthest[cell], p.norm());
  }
  return cells;
}

}  // namespace

SightGrid sightGridOf(const std::vector<Cloud>& samples, bool planar) {
  SightGrid grid;
  grid.planar = planar;
  float lowest = kPi / 2, highest = -kPi / 2;
  for (const Cloud& cloud : samples)
    for (std::size_t i = 0; i < cloud.size() && !planar; ++i) {
      if (!isReturn(cloud.point(i))) continue;
      lowest = std::min(lowest, elevationOf(cloud.point(i)));
      highest = std::max(highest, elevationOf(cloud.point(i)));
    }
  const float spacing = planar ? kPi / 180 : std::clamp(1.25F * beamSpacing(samples), 0.25F * kPi / 180, 4 * kPi / 180);
  grid.columns = static_cast<std::size_t>(2 * kPi / std::clamp(spacing, 0.35F * kPi / 180, 0.5F * kPi / 180));
  grid.column_rad = 2 * kPi / static_cast<float>(grid.columns);
  grid.row_rad = planar ? 1 : spacing;
  grid.lowest_rad = planar || highest < lowest ? -grid.row_rad / 2 : lowest - spacing / 4;
  grid.rows = planar || highest < lowest ? 1 : static_cast<std::size_t>((highest - grid.lowest_rad) / grid.row_rad) + 1;
  grid.fires.assign(grid.rows * grid.columns, 0);
  for (const Cloud& cloud : samples) {
    const CellRanges cells = cellRanges(cloud, grid);
    for (std::size_t cell = 0; cell < grid.fires.size(); ++cell)
      if (cells.farthest[cell] >= 0) grid.fires[cell] = 1;
  }
  return grid;
}

SightImage::SightImage(const Cloud& cloud_sensor, const SightGrid& grid) {
  const CellRanges cells = cellRanges(cloud_sensor, grid);
  const auto rows = static_cast<std::ptrdiff_t>(grid.rows), columns = static_cast<std::ptrdiff_t>(grid.columns);
  corners_.reserve((grid.rows + 1) * grid.columns);
  for (std::ptrdiff_t row = 0; row <= rows; ++row)
    for (std::ptrdiff_t column = 0; column < columns; ++column) {
      Corner corner{0, kSky, -1};
      int filled = 0, firing = 0, filled_around = 0;
      for (std::ptrdiff_t r = row - 2; r <= row + 1; ++r)
        for (std::ptrdiff_t c = column - 2; c <= column + 1; ++c) {
          const std::size_t cell = grid.at(static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(r, 0, rows - 1)),
                                           static_cast<std::size_t>((c + columns) % columns));
          const bool hit = cells.farthest[cell] >= 0;
          filled_around += hit;
          if (r < row - 1 || r > row || c < column - 1 || c > column) continue;
          filled += hit, firing += grid.fires[cell];
          corner.nearest = std::min(corner.nearest, cells.nearest[cell]);
          corner.farthest = std::max(corner.farthest, cells.farthest[cell]);
        }
      if (filled >= 2) corner.free_below = corner.nearest;
      if (filled_around == 0 && firing == 4) corner.free_below = kSky;
      if (filled == 0) corner.nearest = -1;
      corners_.push_back(corner);
    }
}

void SightImage::vote(const Cloud& cloud, const Pose& T_view_cloud, const SightGrid& grid, const SightMargins& margins,
                      SightVotes& votes) const {
  Projection to{};
  for (std::size_t i = 0; i < 12; ++i)
    to.T[i] = static_cast<float>(T_view_cloud.matrix()(static_cast<int>(i / 4), static_cast<int>(i % 4)));
  to.columns_per_rad = 1 / grid.column_rad, to.rows_per_rad = 1 / grid.row_rad, to.lowest_rad = grid.lowest_rad;
  to.last_row = static_cast<float>(grid.rows), to.columns = static_cast<std::int32_t>(grid.columns);
  to.level = grid.planar ? 0 : 1;
  std::array<float, kBlock> range;
  std::array<std::int32_t, kBlock> corner;
  for (std::size_t begin = 0; begin < cloud.size(); begin += kBlock) {
    const std::size_t n = std::min(kBlock, cloud.size() - begin);
    project(&cloud.x[begin], &cloud.y[begin], &cloud.z[begin], n, to, range.data(), corner.data());
    for (std::size_t i = 0; i < n; ++i) {
      if (corner[i] == kOutside || !(range[i] >= margins.nearest_m)) continue;
      const Corner& seen = corners_[static_cast<std::size_t>(corner[i])];
      const float r = range[i], margin = margins.margin_m + margins.margin_per_m * r;
      if (seen.free_below == kSky ? r < margins.sky_m : r + margin < seen.free_below)
        ++votes.free[begin + i];
      else if (seen.farthest >= 0 && (std::abs(r - seen.nearest) <= margin || std::abs(r - seen.farthest) <= margin))
        ++votes.surface[begin + i];
    }
  }
}

}  // namespace scslam
