// Point-to-plane registration against the planes that the target's voxels hold, coarse to fine (core/scan_match.h).
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "scslam/core/scan_match.h"
#include "scslam/registration/registration.h"

namespace scslam {
namespace {

/// Neighbouring points share their plane's error, the calibration and the incidence angle: so many of them count as
/// one.
constexpr double kPointsPerIndependentOne = 25;

class VoxelPlanes : public Registration {
 public:
  struct Params : ParamSetOf<Params> {
    double voxel_m = 0.75, planar_voxel_m = 0.2;
    int levels = 3, planar_levels = 4, max_iterations = 30;
    double inlier_m = 0.2, planar_inlier_m = 0.1, sigma_m = 0.03;
    void describe(ParamVisitor& v) override {
      v.field("voxel_m", voxel_m, "edge of the finest voxels [m]; each level doubles it", 0.05, 10);
      v.field("levels", levels, "levels; the coarsest catches a poor start", 1, 8);
      v.field("planar_voxel_m", planar_voxel_m, "the same for 2-D data [m]", 0.02, 10);
      v.field("planar_levels", planar_levels, "the same for 2-D data", 1, 8);
      v.field("max_iterations", max_iterations, "per level", 1, 1000);
      v.field("inlier_m", inlier_m, "a point nearer to its plane than this is an inlier [m]", 0.01, 5);
      v.field("planar_inlier_m", planar_inlier_m, "the same for 2-D data [m]", 0.01, 5);
      v.field("sigma_m", sigma_m, "noise of a point along the surface normal, one sigma [m]", 0.001, 1);
    }
  };

  VoxelPlanes(const Params& params, const PluginContext& context) : params_(params), threads_(context.threads) {}

  void setTarget(const Cloud& target) override {
    target_.x = target.x, target_.y = target.y, target_.z = target.z;
    map_.reset();
  }

  RegistrationResult align(const Cloud& source, const Pose& T_target_source_guess, bool planar) override {
    const SurfacePyramid& map = mapFor(planar);
    MatchOptions options;
    options.planar = planar;
    options.max_iterations = params_.max_iterations;
    options.sigma_m = params_.sigma_m;
    MatchResult match;
    match.T_map_scan = T_target_source_guess;
    for (int level = map.levels() - 1; level >= 0; --level) {
      const double size = map.level(level).voxelSize();
      options.levels = {level, std::min(level + 1, map.levels() - 1)};
      options.inlier_m = level == 0 ? inlier(planar) : 0.25 * size;
      options.step_m = level == 0 ? 5e-4 : 0.01 * size;
      options.step_rad = level == 0 ? 5e-5 : 1e-3;
      match = matchScan(map, source, match.T_map_scan, options, threads_);
    }
    return resultOf(match, source, map);
  }

 private:
  double inlier(bool planar) const { return planar ? params_.planar_inlier_m : params_.inlier_m; }

  const SurfacePyramid& mapFor(bool planar) {
    if (!map_ || planar_ != planar) {
      SurfelRules rules;
      rules.planar = planar;
      if (planar) rules.min_points = 3;
      map_.emplace(planar ? params_.planar_voxel_m : params_.voxel_m, planar ? params_.planar_levels : params_.levels,
                   rules);
      map_->insert(target_, Pose::Identity());
      planar_ = planar;
    }
    return *map_;
  }

  static RegistrationResult resultOf(const MatchResult& match, const Cloud& source, const SurfacePyramid& map) {
    RegistrationResult result;
    result.T_target_source = match.T_map_scan;
    result.hessian = match.system.H / kPointsPerIndependentOne;
    result.converged = match.converged;
    result.iterations = match.iterations;
    result.inlier_ratio = match.system.matched ? static_cast<double>(match.system.inliers) / match.system.matched : 0;
    result.rmse_m = match.rmse();
    result.degenerate_axes = match.degenerate_axes;
    result.overlap = overlap(source, match.T_map_scan, map.level(std::min(1, map.levels() - 1)));
    return result;
  }

  /// Share of the source that lies in voxels where the target has points.
  static double overlap(const Cloud& source, const Pose& T_target_source, const VoxelSurface& level) {
    if (source.empty()) return 0;
    const double inverse = 1 / level.voxelSize();
    std::size_t inside = 0;
    for (std::size_t i = 0; i < source.size(); ++i) {
      const Eigen::Vector3d p = T_target_source * source.point(i).cast<double>() * inverse;
      inside += level.occupied(packVoxel(p.array().floor().matrix().cast<int>()));
    }
    return static_cast<double>(inside) / static_cast<double>(source.size());
  }

  Params params_;
  ThreadPool& threads_;
  Cloud target_;
  std::optional<SurfacePyramid> map_;
  bool planar_ = false;
};

}  // namespace

SCSLAM_REGISTER(Registration, VoxelPlanes, "voxel_planes", "point-to-plane on the planes of voxels, coarse to fine")

}  // namespace scslam
