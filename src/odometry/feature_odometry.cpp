#include "scslam/odometry/feature_odometry.h"

#include "scslam/core/voxel_filter.h"
#include "scslam/odometry/block_match.h"

namespace scslam {
namespace {

Cloud chosen(const Cloud& cloud, const std::vector<std::uint32_t>& points) {
  Cloud result = selected(cloud, points);
  if (!cloud.hasTime()) return result;
  for (const std::uint32_t i : points) result.dt.push_back(cloud.dt[i]);
  return result;
}

// A scan alone is sparse: its surfaces and edges show only in larger voxels.
constexpr double kScanVoxels = 2.0;
constexpr double kLeastScanInliers = 0.3;
constexpr double kEdgeSigmas = 12;  // an edge's, in a plane's

}  // namespace

ScanToMap::Features FeatureOdometry::featuresOf(const Cloud& cloud, const CurvatureFeatures& features) const {
  Features parts(kParts);
  parts[kSurface] = thin(chosen(cloud, features.less_flat), 0.4 * voxelSize());
  parts[kEdges] = chosen(cloud, features.less_sharp);
  parts[kFlat] = chosen(cloud, features.flat);
  parts[kSharp] = chosen(cloud, features.sharp);
  return parts;
}

void FeatureOdometry::clearMap() {
  ScanToMap::clearMap();
  lines_.emplace(voxelSize(), kLevels, SurfelRules::edges());
  last_.reset();
}

void FeatureOdometry::insert(const Features& features, const Pose& T_odom_base) {
  ScanToMap::insert(features, T_odom_base);
  lines_->insert(features[kEdges], T_odom_base);
  keepLast(features[kSurface], features[kEdges]);
}

void FeatureOdometry::keepLast(const Cloud& surface, const Cloud& edges) {
  last_surface_ = surface, last_edges_ = edges;
  last_.emplace(FeatureMap{{kScanVoxels * voxelSize(), kLevels, SurfelRules::of(false)},
                           {kScanVoxels * voxelSize(), kLevels, SurfelRules::edges()}});
  last_->planes.insert(surface, Pose::Identity());
  last_->lines.insert(edges, Pose::Identity());
}

void FeatureOdometry::forgetBeyond(const Eigen::Vector3d& centre, double radius_m) {
  ScanToMap::forgetBeyond(centre, radius_m);
  lines_->forgetBeyond(centre, radius_m, lines_->level(0).size() / 16 + 64);
}

MatchResult FeatureOdometry::matchFeatures(const SurfacePyramid& planes, const SurfacePyramid& lines,
                                           const Sources& sources, const Pose& T_start,
                                           const MatchOptions& options) const {
  MatchKernel first;
  first.gate_m = planes.level(options.levels.coarsest).voxelSize();
  first.width_m = 0.5 * first.gate_m;
  first.inlier_m = options.inlier_m;
  first.sigma_m = options.sigma_m;
  const auto both = [&](const Pose& T_map_scan, const MatchKernel& kernel) {
    MatchSystem system = linearise(planes, options.levels, sources.surface, T_map_scan, kernel, threads());
    // An edge is seen at the nearest beam, not where it is, and the beams drive along with the robot: edges that
    // counted as much as planes would hold each step back.
    MatchKernel rough = kernel;
    rough.sigma_m *= kEdgeSigmas;
    const MatchSystem edges = lineariseLines(lines, options.levels, sources.edges, T_map_scan, rough, threads());
    addSystem(edges, system);
    system.points += edges.points;
    return system;
  };
  return matchBy(both, T_start, first, leverOf(sources.surface.empty() ? sources.edges : sources.surface), options);
}

Pose FeatureOdometry::closer(const Features& features, const Guess& guess) const {
  if (!last_) return guess.T_odom_base;
  const Pose T_last_base = lastPose().inverse() * guess.T_odom_base;
  MatchOptions options = matchOptions(guess);
  options.T_map_scan_believed = T_last_base;
  options.inlier_m *= kScanVoxels;
  options.sigma_m *= kScanVoxels;
  options.step_m *= 10, options.step_rad *= 10;
  const MatchResult motion = matchLastScan({features[kFlat], features[kSharp]}, T_last_base, options);
  if (motion.inlierRatio() < kLeastScanInliers) return guess.T_odom_base;
  return lastPose() * motion.T_map_scan;
}

MatchResult FeatureOdometry::matchLastScan(const Sources& sources, const Pose& T_start,
                                           const MatchOptions& options) const {
  return matchFeatures(last_->planes, last_->lines, sources, T_start, options);
}

MatchResult FeatureOdometry::match(const Features& features, const Guess& guess, const Pose& T_start) const {
  const Cloud surface = thin(features[kSurface], voxelSize());
  return matchFeatures(planes(), *lines_, {surface, features[kEdges]}, T_start, matchOptions(guess));
}

void FeatureOdometry::saveMap(ByteWriter& state) const {
  ScanToMap::saveMap(state);
  lines_->save(state);
  saveCloud(state, last_surface_);
  saveCloud(state, last_edges_);
}

void FeatureOdometry::loadMap(ByteReader& state) {
  ScanToMap::loadMap(state);
  lines_->load(state);
  Cloud surface, edges;
  loadCloud(state, surface);
  loadCloud(state, edges);
  keepLast(surface, edges);
}

}  // namespace scslam
