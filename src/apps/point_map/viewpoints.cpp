#include "scslam/apps/point_map/viewpoints.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scslam/apps/ground_cells.h"

namespace scslam {
namespace {

constexpr float kCell_m = GroundCells::kCell_m;
constexpr float kBare_m = 0.15F;                         ///< the lowest point of bare ground is no higher above it
constexpr float kBody_m[] = {0.4F, 2.5F};                ///< heights in which nothing may be where a robot stands
constexpr float kStep_m = 0.3F;                          ///< ground hangs together across less
constexpr int kWidest = 4;                               ///< more room than this many cells is not asked for
constexpr double kLeastArea_m2 = 50, kLeastShare = 0.1;  ///< of ground that hangs together; of the largest such

struct Cell {
  std::int32_t x, y;
  float lowest, ground;
  bool blocked;
  int room = 0;  ///< cells to the nearest one where no robot fits
};

class GroundPlan {
 public:
  explicit GroundPlan(const Cloud& cloud_map) {
    const auto low = lowPoints(cloud_map, Eigen::Vector3f::Zero(), std::numeric_limits<float>::max());
    const GroundCells ground({&low});
    for (const LowPoint& point : low) {
      index_.findOrInsert(point.cell);
      const VoxelCoord at = unpackVoxel(point.cell);
      const float z =
          ground.groundAt(kCell_m * (static_cast<float>(at.x()) + 0.5F), kCell_m * (static_cast<float>(at.y()) + 0.5F));
      cells_.push_back({at.x(), at.y(), point.z, z, false});
    }
    for (std::size_t i = 0; i < cloud_map.size(); ++i) {
      const Eigen::Vector3f p = cloud_map.point(i);
      if (!p.allFinite()) continue;
      Cell& cell = cells_[index_.find(packVoxel(floorToInt(p.x() / kCell_m), floorToInt(p.y() / kCell_m), 0))];
      const float height = p.z() - cell.ground;
      cell.blocked |= height > kBody_m[0] && height < kBody_m[1];
    }
    measureRoom();
  }

  /// By number; the roomiest first.
  std::vector<std::uint32_t> standable() const {
    const std::vector<std::uint32_t> piece = pieces();
    std::vector<std::size_t> area;
    for (const std::uint32_t p : piece) {
      if (p == kNone) continue;
      area.resize(std::max<std::size_t>(area.size(), p + 1));
      ++area[p];
    }
    const std::size_t largest = area.empty() ? 0 : *std::max_element(area.begin(), area.end());
    const double least = std::max(kLeastArea_m2 / (kCell_m * kCell_m), kLeastShare * static_cast<double>(largest));
    std::vector<std::uint32_t> standable;
    for (std::uint32_t c = 0; c < cells_.size(); ++c)
      if (piece[c] != kNone && static_cast<double>(area[piece[c]]) >= least) standable.push_back(c);
    std::sort(standable.begin(), standable.end(), [this](std::uint32_t a, std::uint32_t b) {
      const Cell &p = cells_[a], &q = cells_[b];
      return std::tuple(-p.room, p.x, p.y) < std::tuple(-q.room, q.x, q.y);
    });
    return standable;
  }
  Eigen::Vector3f middle(std::uint32_t c) const {
    return {kCell_m * (static_cast<float>(cells_[c].x) + 0.5F), kCell_m * (static_cast<float>(cells_[c].y) + 0.5F),
            cells_[c].ground};
  }

 private:
  static constexpr std::uint32_t kNone = VoxelIndex::kAbsent;

  std::uint32_t beside(std::uint32_t c, int d) const {
    return index_.find(packVoxel(cells_[c].x + d % 3 - 1, cells_[c].y + d / 3 - 1, 0));
  }
  bool fits(std::uint32_t c) const { return !cells_[c].blocked && cells_[c].lowest - cells_[c].ground < kBare_m; }

  /// Rings around what does not fit, one after the other. Cells that nobody has seen do not count as obstacles.
  void measureRoom() {
    for (Cell& cell : cells_) cell.room = kWidest;
    std::vector<std::uint32_t> ring;
    for (std::uint32_t c = 0; c < cells_.size(); ++c)
      if (!fits(c)) cells_[c].room = 0, ring.push_back(c);
    for (int room = 1; room < kWidest; ++room) {
      std::vector<std::uint32_t> next;
      for (const std::uint32_t c : ring)
        for (int d = 0; d < 9; ++d)
          if (const std::uint32_t other = beside(c, d); other != kNone && cells_[other].room > room)
            cells_[other].room = room, next.push_back(other);
      ring = std::move(next);
    }
  }

  /// Cells with room, by the piece of ground they hang together with.
  std::vector<std::uint32_t> pieces() const {
    std::vector<std::uint32_t> piece(cells_.size(), kNone), reached;
    std::uint32_t count = 0;
    for (std::uint32_t first = 0; first < cells_.size(); ++first) {
      if (cells_[first].room < 2 || piece[first] != kNone) continue;
      piece[first] = count;
      reached.assign(1, first);
      while (!reached.empty()) {
        const std::uint32_t c = reached.back();
        reached.pop_back();
        for (int d = 0; d < 9; ++d) {
          const std::uint32_t other = beside(c, d);
          if (other == kNone || piece[other] != kNone || cells_[other].room < 2) continue;
          if (std::abs(cells_[other].ground - cells_[c].ground) > kStep_m) continue;
          piece[other] = count;
          reached.push_back(other);
        }
      }
      ++count;
    }
    return piece;
  }

  VoxelIndex index_;
  std::vector<Cell> cells_;
};

/// Chosen from the front, none within spacing_m of one chosen before.
std::vector<Eigen::Vector3f> thinnedOut(const GroundPlan& plan, float spacing_m) {
  VoxelIndex squares;
  std::vector<std::vector<Eigen::Vector3f>> by_square;
  std::vector<Eigen::Vector3f> chosen;
  const auto squareOf = [spacing_m](const Eigen::Vector3f& p, int dx, int dy) {
    return packVoxel(floorToInt(p.x() / spacing_m) + dx, floorToInt(p.y() / spacing_m) + dy, 0);
  };
  for (const std::uint32_t cell : plan.standable()) {
    const Eigen::Vector3f p = plan.middle(cell);
    bool taken = false;
    for (int d = 0; d < 9 && !taken; ++d)
      if (const std::uint32_t s = squares.find(squareOf(p, d % 3 - 1, d / 3 - 1)); s != VoxelIndex::kAbsent)
        for (const Eigen::Vector3f& other : by_square[s]) taken |= (other - p).head<2>().norm() < spacing_m;
    if (taken) continue;
    const std::uint32_t own = squares.findOrInsert(squareOf(p, 0, 0));
    if (own == by_square.size()) by_square.emplace_back();
    by_square[own].push_back(p);
    chosen.push_back(p);
  }
  return chosen;
}

}  // namespace

std::vector<Eigen::Vector3f> groundViewpoints(const Cloud& cloud_map, double spacing_m) {
  std::vector<Eigen::Vector3f> tour = thinnedOut(GroundPlan(cloud_map), static_cast<float>(spacing_m));
  for (std::size_t i = 0; i + 1 < tour.size(); ++i) {
    const auto nearer = [&here = tour[i]](const Eigen::Vector3f& p, const Eigen::Vector3f& q) {
      return (p - here).squaredNorm() < (q - here).squaredNorm();
    };
    std::iter_swap(tour.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                   std::min_element(tour.begin() + static_cast<std::ptrdiff_t>(i) + 1, tour.end(), nearer));
  }
  return tour;
}

}  // namespace scslam
