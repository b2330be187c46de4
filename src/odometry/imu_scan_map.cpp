#include "scslam/odometry/imu_scan_map.h"

#include <algorithm>
#include <cmath>

#include "scslam/core/voxel_filter.h"
#include "scslam/odometry/usable_points.h"

namespace scslam {
namespace {

constexpr int kLevels = 3;
constexpr std::size_t kThinAbove = 4000;  // smaller scans are used whole
constexpr double kLeastInliers = 0.1;

}  // namespace

void ImuScanMap::Params::describe(ParamVisitor& visitor) {
  visitor.field("voxel_m", voxel_m, "finest map voxel [m]; 0: from the ranges of the first scan", 0.0, 10.0);
  visitor.field("min_range_m", min_range_m, "nearer points are dropped [m]; 0: 1.0 (planar scans 0.1)", 0.0, 100.0);
  visitor.field("max_range_m", max_range_m, "farther points are dropped [m]", 1.0, 1000.0);
  visitor.field("max_iterations", max_iterations, "Gauss-Newton iterations per scan", 1, 1000);
  visitor.field("degenerate_share", degenerate_share,
                "directions with less than this share of a scan's information are left to the prediction", 0.0, 1.0);
}

Cloud ImuScanMap::inRange(const Scan& scan) const {
  return usablePoints(scan, params_.min_range_m, params_.max_range_m);
}

bool ImuScanMap::tooFew(const Cloud& cloud, bool planar) const { return cloud.size() < leastPoints(planar); }

void ImuScanMap::start(const Cloud& cloud, bool planar) {
  planar_ = planar;
  voxel_m_ = params_.voxel_m;
  if (voxel_m_ <= 0) voxel_m_ = voxelFor(cloud, planar);
  map_ = emptyMap();
}

SurfacePyramid ImuScanMap::emptyMap() const { return {voxel_m_, kLevels, SurfelRules::of(planar_)}; }

void ImuScanMap::restart() {
  map_ = emptyMap();
  usual_inliers_ = 0;
}

Cloud ImuScanMap::thin(const Cloud& cloud) const {
  if (cloud.size() <= kThinAbove) return cloud;
  const std::vector<std::uint32_t> kept = onePerVoxel(cloud, 0.6 * voxel_m_);
  Cloud thin = selected(cloud, kept);
  if (!cloud.hasTime()) return thin;
  thin.dt.reserve(kept.size());
  for (const std::uint32_t i : kept) thin.dt.push_back(cloud.dt[i]);
  return thin;
}

void ImuScanMap::insert(const Cloud& thin, const Pose& T_odom_base) {
  map_->insert(thin, T_odom_base);
  map_->forgetBeyond(T_odom_base.translation(), 1.25 * params_.max_range_m, map_->level(0).size() / 16 + 64);
}

MatchOptions ImuScanMap::options() const {
  MatchOptions options;
  options.levels = {0, kLevels - 1};
  options.max_iterations = params_.max_iterations;
  options.inlier_m = (planar_ ? 0.5 : 0.3) * voxel_m_;
  options.sigma_m = planar_ ? std::max(0.06 * voxel_m_, 0.02) : 0.06 * voxel_m_;
  options.planar = planar_;
  options.degenerate_share = params_.degenerate_share;
  return options;
}

Cloud ImuScanMap::forMatching(const Cloud& thin) const {
  return thin.size() <= kThinAbove ? thin : selected(thin, onePerVoxel(thin, voxel_m_));
}

MatchResult ImuScanMap::match(const Cloud& thin, const Pose& T_odom_base_guess,
                              const Matrix6d& guess_information) const {
  MatchOptions with = options();
  with.guess_information = guess_information;
  return matchScan(*map_, forMatching(thin), T_odom_base_guess, with, context_.threads);
}

MatchResult ImuScanMap::search(const Cloud& thin, const Pose& T_odom_base_guess, double reach_m,
                               double reach_rad) const {
  const double coarse_m = voxel_m_ * (1 << (kLevels - 1));
  PoseGrid grid;
  grid.yaw_range_rad = reach_rad;
  grid.yaw_step_rad = 0.07;
  grid.xy_range_m = reach_m;
  grid.xy_step_m = 0.5 * coarse_m;
  return searchAndMatch(*map_, forMatching(thin), T_odom_base_guess, grid, options(), context_.threads);
}

double ImuScanMap::score(const Cloud& thin, const Pose& T_odom_base_guess) const {
  return matchScore(*map_, 1, thinned(thin, 500), T_odom_base_guess, voxel_m_);
}

double ImuScanMap::share(const MatchResult& match) const {
  if (match.system.inliers < leastPoints(planar_) / 2 || match.inlierRatio() < kLeastInliers) return 0.0;
  return usual_inliers_ > 0 ? match.inlierRatio() / usual_inliers_ : 1.0;
}

void ImuScanMap::note(const MatchResult& match) {
  const double ratio = match.inlierRatio();
  usual_inliers_ = usual_inliers_ == 0 ? ratio : 0.9 * usual_inliers_ + 0.1 * ratio;
}

void ImuScanMap::save(ByteWriter& state) const {
  state.put(voxel_m_);
  state.put(planar_);
  state.put(usual_inliers_);
  state.put(map_.has_value());
  if (map_) map_->save(state);
}

void ImuScanMap::load(ByteReader& state) {
  state.get(voxel_m_);
  state.get(planar_);
  state.get(usual_inliers_);
  map_.reset();
  if (!state.get<bool>()) return;
  if (!(voxel_m_ > 0)) throw inputError("a saved local map has no voxel size");
  map_ = emptyMap();
  map_->load(state);
}

}  // namespace scslam
