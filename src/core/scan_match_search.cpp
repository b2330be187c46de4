#include <algorithm>
#include <cmath>

#include "scslam/core/scan_match.h"

namespace scslam {
namespace {

struct Cell {
  Pose T_map_scan;
  double score = 0;
};

/// Offsets -range … range in equal steps of at most `step`, 0 first, then outwards.
std::vector<double> offsets(double range, double step) {
  std::vector<double> result = {0.0};
  const int n = static_cast<int>(std::ceil(range / step - 1e-9));
  for (int i = 1; i <= n; ++i) {
    result.push_back(range * i / n);
    result.push_back(-range * i / n);
  }
  return result;
}

std::vector<Cell> cellsOf(const Pose& T_guess, const Eigen::Vector3d& up, const PoseGrid& grid) {
  const auto yaws = offsets(std::min(grid.yaw_range_rad, M_PI), grid.yaw_step_rad);
  const auto shifts = offsets(grid.xy_range_m, grid.xy_step_m), heights = offsets(grid.z_range_m, grid.z_step_m);
  std::vector<Cell> cells;
  cells.reserve(yaws.size() * shifts.size() * shifts.size() * heights.size());
  for (const double yaw : yaws) {
    Pose T = T_guess;
    T.linear() = Eigen::AngleAxisd(yaw, up).toRotationMatrix() * T_guess.linear();
    for (const double dx : shifts)
      for (const double dy : shifts)
        for (const double dz : heights) {
          T.translation() = T_guess.translation() + Eigen::Vector3d(dx, dy, dz);
          cells.push_back({T, 0});
        }
  }
  return cells;
}

/// The `count` best cells that are not neighbours of a better one.
std::vector<Cell> bestCells(std::vector<Cell> cells, const PoseGrid& grid, int count) {
  std::stable_sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) { return a.score > b.score; });
  std::vector<Cell> best;
  for (const Cell& cell : cells) {
    if (best.size() == static_cast<std::size_t>(count)) break;
    const bool near_better = std::any_of(best.begin(), best.end(), [&](const Cell& other) {
      const Vector6d d = local(other.T_map_scan, cell.T_map_scan);
      return d.head<3>().norm() < 1.01 * grid.xy_step_m && d.tail<3>().norm() < 1.01 * grid.yaw_step_rad;
    });
    if (!near_better) best.push_back(cell);
  }
  return best;
}

/// A start of the search is not the guess: it must not be held where it is.
MatchOptions quick(MatchOptions options, int iterations) {
  options.guess_information.setZero();
  options.max_iterations = iterations;
  options.step_m = 5e-3;
  options.step_rad = 5e-4;
  return options;
}

}  // namespace

Cloud thinned(const Cloud& cloud, std::size_t max_points) {
  Cloud result;
  const std::size_t n = std::min(cloud.size(), max_points);
  result.reserve(n);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t i = k * cloud.size() / n;
    result.push(cloud.x[i], cloud.y[i], cloud.z[i]);
  }
  return result;
}

SearchResult searchFrom(const SurfacePyramid& map, const Cloud& source, const std::vector<SearchStart>& starts,
                        const MatchOptions& options, ThreadPool& threads) {
  constexpr std::size_t kCellsAtOnce = 32, kRefinePoints = 1500;
  constexpr int kSlides = 48;
  const Pose& T_guess = starts.front().T_map_scan_guess;
  const PoseGrid& grid = starts.front().grid;
  SearchResult result;
  if (source.empty() || map.empty() || !isRigid(T_guess)) {
    result.best = matchScan(map, source, T_guess, options, threads);
    return result;
  }

  const int coarsest = options.levels.coarsest;
  const double coarse_m = map.level(coarsest).voxelSize();
  // A sensor is seldom mounted level: its z axis is not the axis it turns about, and half a turn doubles the
  // difference.
  const Eigen::Vector3d up = options.planar ? Eigen::Vector3d::UnitZ().eval()
                                            : map.level(coarsest).upNear(T_guess.translation(), 20 * coarse_m);
  std::vector<Cell> cells;
  for (const SearchStart& start : starts) {
    const std::vector<Cell> more = cellsOf(start.T_map_scan_guess, up, start.grid);
    cells.insert(cells.end(), more.begin(), more.end());
  }
  const Cloud few = thinned(source, grid.max_points);
  threads.forEachChunk(cells.size(), kCellsAtOnce, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i)
      cells[i].score = matchScore(map, coarsest, few, cells[i].T_map_scan, 0.5 * coarse_m);
  });
  const int middle = std::max(options.levels.finest, coarsest - 1);
  MatchOptions coarsest_only = quick(options, 8), coarse = quick(options, 12), fine = quick(options, 12);
  coarsest_only.levels = {coarsest, coarsest};
  coarse.levels = {middle, coarsest};

  // The basin of a cell is wider than its score's peak, so many cells slide to their peak before a few are kept.
  std::vector<Cell> best_cells = bestCells(std::move(cells), grid, kSlides);
  threads.forEachChunk(best_cells.size(), 1, [&](std::size_t begin, std::size_t end, std::size_t) {
    ThreadPool alone;
    for (std::size_t i = begin; i < end; ++i) {
      Cell& cell = best_cells[i];
      cell.T_map_scan = matchScan(map, few, cell.T_map_scan, coarsest_only, alone).T_map_scan;
      cell.score = matchScore(map, middle, few, cell.T_map_scan, 0.5 * map.level(middle).voxelSize());
    }
  });
  best_cells = bestCells(std::move(best_cells), grid, grid.candidates);
  best_cells.insert(best_cells.begin(), Cell{T_guess, 0});

  const Cloud some = thinned(source, kRefinePoints);
  MatchResult best;
  best.T_map_scan = T_guess;
  for (const Cell& start : best_cells) {
    const MatchResult rough = matchScan(map, some, start.T_map_scan, coarse, threads);
    MatchResult refined = matchScan(map, some, rough.T_map_scan, fine, threads);
    result.rivals.push_back({refined.T_map_scan, refined.meanScore()});
    if (refined.meanScore() > best.meanScore()) best = refined;
  }
  for (RivalPose& rival : result.rivals) rival.share /= std::max(best.meanScore(), 1e-9);
  std::stable_sort(result.rivals.begin(), result.rivals.end(),
                   [](const RivalPose& a, const RivalPose& b) { return a.share > b.share; });
  MatchOptions full = options;
  full.guess_information.setZero();
  result.best = matchScan(map, source, best.T_map_scan, full, threads);
  return result;
}

MatchResult searchAndMatch(const SurfacePyramid& map, const Cloud& source, const Pose& T_map_scan_guess,
                           const PoseGrid& grid, const MatchOptions& options, ThreadPool& threads) {
  return searchFrom(map, source, {{T_map_scan_guess, grid}}, options, threads).best;
}

}  // namespace scslam
