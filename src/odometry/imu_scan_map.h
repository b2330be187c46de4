// Scans made ready and matched to a local map of voxel planes: the half of an inertial front-end that knows LiDAR.
#pragma once
#include <optional>

#include "scslam/core/scan_match.h"
#include "scslam/odometry/odometry.h"

namespace scslam {

class ImuScanMap {
 public:
  struct Params : ParamSetOf<Params> {
    double voxel_m = 0;      ///< finest map voxel; 0: from the first scan's ranges
    double min_range_m = 0;  ///< nearer points are the robot itself; 0: 1.0, 0.1 for planar scans
    double max_range_m = 100;
    int max_iterations = 20;
    /// A direction with less than this share of the information is left to the prediction. Normals err by a few
    /// degrees, so that a bare tunnel has some 0.003 along its axis that nothing stands for; ends and bends have 0.03
    /// and more.
    double degenerate_share = 0.01;
    void describe(ParamVisitor& visitor) override;
  };
  ImuScanMap(const Params& params, const PluginContext& context) : params_(params), context_(context) {}

  /// The usable points in frame base, all fields kept.
  Cloud inRange(const Scan& scan) const;
  /// Too few points to match?
  bool tooFew(const Cloud& cloud, bool planar) const;
  /// One point for each fine voxel, with its time: what the map takes and the match is made of.
  Cloud thin(const Cloud& cloud) const;

  bool started() const { return map_.has_value(); }
  /// An empty map, with voxels that suit this cloud.
  void start(const Cloud& cloud, bool planar);
  /// Forgets everything but the voxel size.
  void restart();
  void insert(const Cloud& thin, const Pose& T_odom_base);

  /// @param guess_information of the guess (tangent, frame base): the result is the most likely pose given both.
  MatchResult match(const Cloud& thin, const Pose& T_odom_base_guess, const Matrix6d& guess_information) const;
  /// The best fit within `reach_m` and `reach_rad` about the vertical.
  MatchResult search(const Cloud& thin, const Pose& T_odom_base_guess, double reach_m, double reach_rad) const;
  /// How well a guess fits, 0..1, from a few hundred points.
  double score(const Cloud& thin, const Pose& T_odom_base_guess) const;
  /// Inlier ratio as a share of the usual one; 0 when there are too few.
  double share(const MatchResult& match) const;
  /// This match was taken: its inlier ratio becomes part of what is usual.
  void note(const MatchResult& match);

  double voxel() const { return voxel_m_; }
  bool planar() const { return planar_; }
  double usualInliers() const { return usual_inliers_; }
  void save(ByteWriter& state) const;
  void load(ByteReader& state);

 private:
  MatchOptions options() const;
  SurfacePyramid emptyMap() const;
  Cloud forMatching(const Cloud& thin) const;

  Params params_;
  PluginContext context_;
  std::optional<SurfacePyramid> map_;
  double voxel_m_ = 0;
  bool planar_ = false;
  double usual_inliers_ = 0;
};

}  // namespace scslam
