#include "scslam/registration/range_image.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace scslam {
namespace {

constexpr std::size_t kColumns = 180, kRows = 90;  // 2 degrees
constexpr float kNearest_m = 0.1f;
constexpr float kNothing = std::numeric_limits<float>::infinity();

std::size_t binOf(float angle, float turn, std::size_t bins) {
  const auto bin = static_cast<std::ptrdiff_t>(angle / turn * static_cast<float>(bins));
  return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(bin, 0, static_cast<std::ptrdiff_t>(bins) - 1));
}

}  // namespace

RangeImage::RangeImage(const Cloud& cloud, const Eigen::Vector3f& viewpoint, bool planar)
    : viewpoint_(viewpoint), planar_(planar), rows_(planar ? 1 : kRows) {
  std::vector<Cell> seen(rows_ * kColumns, {kNothing, -1});
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    float range = 0;
    const std::size_t cell = cellOf(cloud.point(i), range);
    if (!(range >= kNearest_m) || !std::isfinite(range)) continue;
    seen[cell].nearest = std::min(seen[cell].nearest, range);
    seen[cell].farthest = std::max(seen[cell].farthest, range);
  }
  spread(seen);
}

void RangeImage::spread(const std::vector<Cell>& seen) {
  around_.assign(seen.size(), {kNothing, -1});
  for (std::size_t row = 0; row < rows_; ++row)
    for (std::size_t column = 0; column < kColumns; ++column) {
      if (seen[row * kColumns + column].farthest < 0) continue;
      Cell& cell = around_[row * kColumns + column];
      for (std::size_t r = row > 0 ? row - 1 : 0; r <= std::min(row + 1, rows_ - 1); ++r)
        for (const std::size_t c : {(column + kColumns - 1) % kColumns, column, (column + 1) % kColumns}) {
          cell.nearest = std::min(cell.nearest, seen[r * kColumns + c].nearest);
          cell.farthest = std::max(cell.farthest, seen[r * kColumns + c].farthest);
        }
    }
}

std::size_t RangeImage::cellOf(const Eigen::Vector3f& p, float& range_m) const {
  const Eigen::Vector3f d = p - viewpoint_;
  const float level = std::hypot(d.x(), d.y());
  range_m = planar_ ? level : d.norm();
  if (!(range_m >= kNearest_m)) return 0;
  const float pi = static_cast<float>(M_PI);
  const std::size_t column = binOf(std::atan2(d.y(), d.x()) + pi, 2 * pi, kColumns);
  return planar_ ? column : binOf(std::atan2(d.z(), level) + pi / 2, pi, kRows) * kColumns + column;
}

Sight RangeImage::at(const Eigen::Vector3f& p, float margin_m) const {
  float range = 0;
  const Cell& cell = around_[cellOf(p, range)];
  if (!(range >= kNearest_m) || cell.farthest < 0) return Sight::kUnknown;
  if (range + margin_m < cell.nearest) return Sight::kFree;
  return range > cell.farthest + margin_m ? Sight::kBehind : Sight::kSurface;
}

}  // namespace scslam
