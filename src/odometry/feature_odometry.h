// Odometry by edges and planes: scan to scan for a start, then scan to map (LOAM). What is a feature, and in which
// steps a motion is solved for, is the front-end's.
#pragma once
#include "scslam/odometry/curvature_features.h"
#include "scslam/odometry/scan_to_map.h"

namespace scslam {

class FeatureOdometry : public ScanToMap {
 protected:
  /// Elements of Features. Surfaces are thinned and make the map's planes, edges its lines; flat and sharp are the best
  /// of them, matched scan to scan.
  enum Part : std::size_t { kSurface, kEdges, kFlat, kSharp, kParts };

  /// Voxel planes and voxel lines.
  struct FeatureMap {
    SurfacePyramid planes, lines;
  };
  /// What is matched with a FeatureMap.
  struct Sources {
    const Cloud& surface;
    const Cloud& edges;
  };

  FeatureOdometry(const ScanToMapParams& params, const PluginContext& context) : ScanToMap(params, context) {}

  /// The points of a scan as features: thins the surface points.
  Features featuresOf(const Cloud& cloud, const CurvatureFeatures& chosen) const;

  Pose closer(const Features& features, const Guess& guess) const override;
  MatchResult match(const Features& features, const Guess& guess, const Pose& T_start) const override;
  void insert(const Features& features, const Pose& T_odom_base) override;
  void clearMap() override;
  void forgetBeyond(const Eigen::Vector3d& centre, double radius_m) override;
  void saveMap(ByteWriter& state) const override;
  void loadMap(ByteReader& state) override;

  /// The motion since the last scan. Default: all six axes at once, planes and lines together.
  virtual MatchResult matchLastScan(const Sources& sources, const Pose& T_start, const MatchOptions& options) const;
  MatchResult matchFeatures(const SurfacePyramid& planes, const SurfacePyramid& lines, const Sources& sources,
                            const Pose& T_start, const MatchOptions& options) const;
  const FeatureMap& lastScan() const { return *last_; }

 private:
  void keepLast(const Cloud& surface, const Cloud& edges);

  std::optional<SurfacePyramid> lines_;  ///< of the map, frame odom
  std::optional<FeatureMap> last_;       ///< of the last scan alone, frame base of it
  Cloud last_surface_, last_edges_;      ///< what last_ was made of, to save it
};

}  // namespace scslam
