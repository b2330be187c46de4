#include "scslam/core/scan_match.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

namespace scslam {

SurfacePyramid::SurfacePyramid(double voxel_m, int levels, const SurfelRules& rules) {
  for (int i = 0; i < levels; ++i) levels_.emplace_back(std::ldexp(voxel_m, i), rules);
}

void SurfacePyramid::insert(const Cloud& cloud_b, const Pose& T_map_b) {
  for (VoxelSurface& level : levels_) level.insert(cloud_b, T_map_b);
}

void SurfacePyramid::forgetBeyond(const Eigen::Vector3d& centre, double radius_m, std::size_t budget) {
  for (VoxelSurface& level : levels_) level.forgetBeyond(centre, radius_m, budget);
}

void SurfacePyramid::save(ByteWriter& state) const {
  for (const VoxelSurface& level : levels_) level.save(state);
}

void SurfacePyramid::load(ByteReader& state) {
  for (VoxelSurface& level : levels_) level.load(state);
}

double MatchSystem::medianResidual(double gate_m) const {
  if (matched == 0) return gate_m;
  std::uint32_t below = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    const std::uint32_t in_bin = histogram[bin];
    if (2 * (below + in_bin) >= matched) {
      const double inside = (0.5 * matched - below) / std::max(in_bin, 1u);
      return (static_cast<double>(bin) + inside) * gate_m / kBins;
    }
    below += in_bin;
  }
  return gate_m;
}

double MatchResult::rmse() const { return system.inliers ? std::sqrt(system.inlier_r2 / system.inliers) : 0.0; }

namespace {

constexpr std::uint32_t kMinMatches = 12;

/// The Gauss-Newton step without the directions that the data does not fix (Zhang 2016, "On degeneracy of
/// optimization-based state estimation"): they keep their guess instead of following noise.
struct Step {
  Vector6d delta = Vector6d::Zero();
  Matrix6d information = Matrix6d::Zero();  ///< of the directions that are fixed
  int degenerate_axes = 0;
};

std::vector<int> heldAxes(const MatchOptions& options) {
  std::vector<int> axes;
  for (int axis = 0; axis < 6; ++axis)
    if (options.held[static_cast<std::size_t>(axis)] || (options.planar && axis >= 2 && axis <= 4))
      axes.push_back(axis);
  return axes;
}

/// @param lever_m turns rotations into lengths, so that one share of information judges all axes.
/// @param from_guess local(T_map_scan_believed, T_map_scan).
Step solve(const MatchSystem& system, double lever_m, const Vector6d& from_guess, const MatchOptions& options) {
  Vector6d scale;
  scale << 1, 1, 1, 1 / lever_m, 1 / lever_m, 1 / lever_m;
  Matrix6d H = scale.asDiagonal() * system.H * scale.asDiagonal();
  Vector6d g = scale.asDiagonal() * system.g;
  const std::vector<int> held = heldAxes(options);
  for (const int axis : held) {
    H.row(axis).setZero();
    H.col(axis).setZero();
    g(axis) = 0;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(H);
  const double least = options.degenerate_share * system.H.topLeftCorner<3, 3>().trace();
  Step step;
  Matrix6d kept = Matrix6d::Zero();  // projector onto the directions that are fixed
  for (int i = 0; i < 6; ++i) {
    const Vector6d v = eigen.eigenvectors().col(i);
    if (!(eigen.eigenvalues()(i) > least)) {
      ++step.degenerate_axes;
      continue;
    }
    kept += v * v.transpose();
    step.delta -= v * (v.dot(g) / eigen.eigenvalues()(i));
    step.information += eigen.eigenvalues()(i) * v * v.transpose();
  }
  if (!options.guess_information.isZero(0.0)) {
    const Matrix6d prior =
        MatchResult::kCorrelatedPoints * scale.asDiagonal() * options.guess_information * scale.asDiagonal();
    const Vector6d pull = prior * scale.cwiseInverse().asDiagonal() * from_guess;
    step.delta = -(step.information + prior).ldlt().solve(kept * g + pull);
  }
  step.degenerate_axes -= static_cast<int>(held.size());
  for (const int axis : held) step.delta(axis) = 0;
  step.delta = scale.asDiagonal() * step.delta;
  const Vector6d unscale = scale.cwiseInverse();
  step.information = unscale.asDiagonal() * step.information * unscale.asDiagonal();
  return step;
}

/// Products of many rotations drift off SO(3), and extrapolating with them doubles the error each time. Keeps a pure
/// heading pure.
void renormalise(Pose& T) { T.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix(); }

}  // namespace

double leverOf(const Cloud& source) {
  double sum = 0;
  for (std::size_t i = 0; i < source.size(); ++i) sum += static_cast<double>(source.point(i).squaredNorm());
  return std::max(std::sqrt(sum / static_cast<double>(std::max<std::size_t>(source.size(), 1))), 1e-3);
}

MatchResult matchBy(const Lineariser& linearise_at, const Pose& T_map_scan_start, MatchKernel kernel, double lever_m,
                    const MatchOptions& options) {
  MatchResult result;
  result.T_map_scan = T_map_scan_start;
  if (!isRigid(T_map_scan_start)) return result;
  const Pose T_believed = options.T_map_scan_believed.value_or(T_map_scan_start);
  const double widest_m = kernel.width_m;
  for (; result.iterations < options.max_iterations; ++result.iterations) {
    result.system = linearise_at(result.T_map_scan, kernel);
    if (result.system.matched < kMinMatches) return result;
    const Step step = solve(result.system, lever_m, local(T_believed, result.T_map_scan), options);
    result.degenerate_axes = step.degenerate_axes;
    result.information = step.information / MatchResult::kCorrelatedPoints;
    result.kernel_width_m = kernel.width_m;
    result.T_map_scan = retract(result.T_map_scan, step.delta);
    renormalise(result.T_map_scan);
    // 3 robust standard deviations; never narrower than the point noise.
    const double sigma = 1.4826 * result.system.medianResidual(kernel.gate_m);
    kernel.width_m = std::clamp(3.0 * sigma, 2.0 * options.sigma_m, widest_m);
    if (step.delta.head<3>().norm() < options.step_m && step.delta.tail<3>().norm() < options.step_rad) {
      result.converged = true;
      break;
    }
  }
  return result;
}

MatchResult matchScan(const SurfacePyramid& map, const Cloud& source, const Pose& T_map_scan_guess,
                      const MatchOptions& options, ThreadPool& threads) {
  if (source.empty() || map.empty()) {
    MatchResult nothing;
    nothing.T_map_scan = T_map_scan_guess;
    return nothing;
  }
  MatchKernel kernel;
  kernel.gate_m = map.level(options.levels.coarsest).voxelSize();
  kernel.width_m = 0.5 * kernel.gate_m;
  kernel.inlier_m = options.inlier_m;
  kernel.sigma_m = options.sigma_m;
  const auto planes = [&](const Pose& T_map_scan, const MatchKernel& now) {
    return linearise(map, options.levels, source, T_map_scan, now, threads);
  };
  return matchBy(planes, T_map_scan_guess, kernel, leverOf(source), options);
}

}  // namespace scslam
