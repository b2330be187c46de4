#include "sim/surface_figures.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>
#include <numbers>
#include <tuple>

#include "sim/kd_tree.h"

namespace scslam::sim {
namespace {

constexpr double kDeg = 180 / std::numbers::pi;

double horizontal(const Eigen::Vector3d& p) { return p.head<2>().norm(); }

/// Middle of the 5 cm interval of heights that most returns share.
double groundHeight(const Points& points) {
  std::vector<double> edges;
  for (int i = 0; i < 80; ++i) edges.push_back(-4 + 0.05 * i);
  std::vector<int> count(edges.size(), 0);
  for (const auto& p : points) {
    const double rho = horizontal(p);
    if (rho <= 4 || rho >= 20 || p.z() >= -0.8 || p.z() < edges.front()) continue;
    ++count[static_cast<std::size_t>(std::upper_bound(edges.begin(), edges.end(), p.z()) - edges.begin()) - 1];
  }
  const auto most = std::max_element(count.begin(), count.end());
  return *most == 0 ? kNotMeasured : edges[static_cast<std::size_t>(most - count.begin())] + 0.025;
}

struct PlaneFit {
  double std_m, mad_m, slope_deg;
};

/// z over x and y by least squares. @return false when the points are few or spread along a line only.
bool fitPlane(const Points& cell, PlaneFit& fit) {
  if (cell.size() < 20) return false;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : cell) mean += p;
  mean /= static_cast<double>(cell.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const auto& p : cell) scatter += (p - mean) * (p - mean).transpose();
  const Eigen::Matrix2d flat = scatter.topLeftCorner<2, 2>();
  const double narrow2 = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(flat, Eigen::EigenvaluesOnly).eigenvalues()[0];
  if (narrow2 < 1.0) return false;  // sum of squares across the widest direction [m^2]
  const Eigen::Vector2d slope = flat.ldlt().solve(scatter.topRightCorner<2, 1>());
  std::vector<double> residuals;
  double sum = 0;
  for (const auto& p : cell) {
    const Eigen::Vector3d d = p - mean;
    residuals.push_back(d.z() - slope.dot(d.head<2>()));
    sum += residuals.back() * residuals.back();
  }
  fit = {std::sqrt(sum / static_cast<double>(cell.size())), robustDeviation(residuals), kDeg * std::atan(slope.norm())};
  return true;
}

/// Centroids of the voxels in the order of their x, y, z; those beyond 40 m left out.
Points voxelCentroids(const Points& points, double voxel_m) {
  struct Entry {
    std::array<int, 3> voxel;
    std::size_t point;
  };
  std::vector<Entry> entries;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto at = [&](int axis) { return static_cast<int>(std::floor(points[i][axis] / voxel_m)); };
    entries.push_back({{at(0), at(1), at(2)}, i});
  }
  std::sort(entries.begin(), entries.end(),
            [](const Entry& a, const Entry& b) { return std::tie(a.voxel, a.point) < std::tie(b.voxel, b.point); });
  Points centroids;
  for (std::size_t i = 0; i < entries.size();) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    std::size_t j = i;
    for (; j < entries.size() && entries[j].voxel == entries[i].voxel; ++j) sum += points[entries[j].point];
    const Eigen::Vector3d centroid = sum / static_cast<double>(j - i);
    if (centroid.norm() < 40) centroids.push_back(centroid);
    i = j;
  }
  return centroids;
}

/// 0 linear, 1 planar, 2 scatter, by the standard deviations along the principal axes; `level`: |z| of the normal.
int shapeOf(const Points& points, const std::vector<std::uint32_t>& members, double& level) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto i : members) mean += points[i];
  mean /= static_cast<double>(members.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const auto i : members) covariance += (points[i] - mean) * (points[i] - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance / static_cast<double>(members.size()));
  const Eigen::Vector3d s = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  level = std::abs(solver.eigenvectors()(2, 0));
  const std::array<double, 3> weight = {s[2] - s[1], s[1] - s[0], s[0]};
  return static_cast<int>(std::max_element(weight.begin(), weight.end()) - weight.begin());
}

}  // namespace

void measureGround(const Points& points, RealismFigures& f) {
  f.ground_height_m = groundHeight(points);
  std::map<std::pair<int, int>, Points> cells;
  double on_ground = 0;
  for (const auto& p : points) {
    const double rho = horizontal(p);
    if (!(std::abs(p.z() - f.ground_height_m) < 0.35) || rho <= 4 || rho >= 25) continue;
    on_ground += 1;
    cells[{static_cast<int>(std::floor(p.x() / 2)), static_cast<int>(std::floor(p.y() / 2))}].push_back(p);
  }
  f.ground_share = share(on_ground, static_cast<double>(points.size()));
  std::vector<double> deviations, robust, slopes;
  for (const auto& [key, cell] : cells)
    if (PlaneFit fit{}; fitPlane(cell, fit))
      deviations.push_back(fit.std_m), robust.push_back(fit.mad_m), slopes.push_back(fit.slope_deg);
  f.ground_cells = static_cast<double>(deviations.size());
  f.ground_plane_std_m = median(deviations);
  f.ground_plane_std_quartiles_m = {percentile(deviations, 25), percentile(deviations, 75)};
  f.ground_plane_mad_m = median(robust);
  f.ground_slope_deg = median(slopes);
}

void measureSpacing(const Points& points, int columns, RealismFigures& f) {
  const KdTree tree(points);
  const double step_rad = 2 * std::numbers::pi / columns;
  std::vector<double> relative;
  std::array<std::vector<double>, kSpacingBins_m.size() - 1> by_range;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double distance = tree.nearestOther(i), range = points[i].norm();
    if (!std::isfinite(distance)) continue;
    relative.push_back(distance / (range * step_rad));
    if (const int bin = binOf(kSpacingBins_m, range); bin >= 0)
      by_range[static_cast<std::size_t>(bin)].push_back(distance);
  }
  for (auto& bin : by_range) f.spacing_m.push_back(bin.size() > 50 ? median(std::move(bin)) : kNotMeasured);
  f.spacing_per_azimuth_step = median(std::move(relative));
}

void measureShape(const Points& points, RealismFigures& f) {
  const Points centroids = voxelCentroids(points, 0.2);
  const KdTree tree(centroids);
  std::vector<std::uint32_t> members;
  std::array<double, 3> shapes = {0, 0, 0};
  double sparse = 0, walls = 0, floors = 0;
  for (std::size_t i = 0; i < centroids.size(); i += 2) {
    tree.within(centroids[i], 1.0, members);
    if (members.size() < 8) {
      sparse += 1;
      continue;
    }
    double level = 0;
    const int shape = shapeOf(centroids, members, level);
    shapes[static_cast<std::size_t>(shape)] += 1;
    if (shape == 1) walls += level < 0.3 ? 1 : 0, floors += level > 0.9 ? 1 : 0;
  }
  const double judged = shapes[0] + shapes[1] + shapes[2];
  f.voxels = static_cast<double>(centroids.size());
  f.sparse_share = share(sparse, sparse + judged);
  for (const double n : shapes) f.linear_planar_scatter.push_back(share(n, judged));
  f.planar_vertical_horizontal = {share(walls, shapes[1]), share(floors, shapes[1])};
}

void measureScanContext(const Points& points, RealismFigures& f) {
  constexpr std::size_t kRings = 20, kSectors = 60;
  std::vector<double> highest(kRings * kSectors, kNotMeasured), heights;
  for (const auto& p : points) {
    heights.push_back(p.z());
    const double rho = horizontal(p);
    if (rho >= 80) continue;
    double azimuth_deg = kDeg * std::atan2(p.y(), p.x());
    if (azimuth_deg < 0) azimuth_deg += 360;
    double& bin =
        highest[static_cast<std::size_t>(rho / 4) * kSectors + static_cast<std::size_t>(azimuth_deg / 6) % kSectors];
    bin = std::fmax(bin, p.z() + 2.0);
  }
  double filled = 0, sum = 0;
  for (std::size_t ring = 0; ring < kRings; ++ring) {
    double in_ring = 0;
    for (std::size_t sector = 0; sector < kSectors; ++sector)
      if (const double height = highest[ring * kSectors + sector]; measured(height)) in_ring += 1, sum += height;
    f.sc_ring_occupancy.push_back(in_ring / kSectors);
    filled += in_ring;
  }
  f.sc_occupancy = filled / (kRings * kSectors);
  f.sc_height_m = share(sum, filled);
  for (const double percent : {5, 50, 95}) f.height_percentiles_m.push_back(percentile(heights, percent));
}

}  // namespace scslam::sim
