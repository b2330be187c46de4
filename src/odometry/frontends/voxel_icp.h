// LiDAR odometry by scan-to-map point-to-plane matching on voxel planes (core/scan_match.h).
//
// Constant velocity (or the recording's own odometry) predicts, a robust kernel that follows the residuals decides, and
// a fit clearly worse than the usual one starts a search over headings and shifts: a turn that the prediction does not
// know of is found again instead of being driven through.
#pragma once
#include <optional>

#include "scslam/core/scan_match.h"
#include "scslam/odometry/odometry.h"

namespace scslam {

class VoxelIcp : public Odometry {
 public:
  struct Params : ParamSetOf<Params> {
    double voxel_m = 0;      ///< finest map voxel; 0: from the first scan's ranges
    double min_range_m = 0;  ///< nearer points are the robot itself; 0: 1.0, 0.1 for planar scans
    double max_range_m = 100;
    std::string deskew = "auto";
    bool use_recorded_odometry = true;
    int max_iterations = 30;
    void describe(ParamVisitor& visitor) override;
  };

  VoxelIcp(const Params& params, const PluginContext& context);

  OdometryStep step(const Scan& scan) override;
  void save(ByteWriter& state) const override;
  void load(ByteReader& state) override;

 private:
  /// A scan made ready: what is handed on, what is put into the map, what is matched.
  struct Prepared {
    Cloud cloud;                       ///< frame base, in range, finite
    Cloud raw_map_points, map_points;  ///< thinned, before and after deskewing
  };
  struct Guess {
    Pose T_odom_base;
    Matrix6d information;  ///< of the step, from recorded odometry; zero: only a place to start from
    bool recorded() const { return !information.isZero(0.0); }
  };
  struct Fit {
    MatchResult match;
    Vector6d twist = Vector6d::Zero();  ///< used for deskewing
    bool deskewed = false;
  };

  /// How far a search looks: an error of recorded odometry, of constant velocity, or a half turn.
  enum class Reach { kStep, kNear, kFar };

  SurfacePyramid emptyMap() const;
  void startMap(const Scan& scan, const Prepared& prepared);
  Cloud inRange(const Scan& scan) const;
  void thin(const Cloud& cloud, Cloud& map_points) const;
  Pose predictedStep(Stamp stamp) const;
  Guess bestGuess(const Scan& scan, const Cloud& source) const;
  Matrix6d recordedInformation(const Pose& T_step) const;
  Vector6d twistOf(const Pose& T_previous_base, Stamp stamp) const;
  bool moreThanNoise(const Vector6d& twist, double sweep_s) const;

  Fit fitScan(Prepared& prepared, const Scan& scan, const Guess& guess);
  Fit fitDeskewed(Prepared& prepared, const Scan& scan, const Guess& guess) const;
  MatchResult matchWith(const Cloud& map_points, const Guess& guess) const;
  MatchResult search(const Cloud& source, const Pose& T_odom_base_guess, Reach reach) const;
  /// Inlier ratio as a share of the usual one; 0 when there are too few.
  double share(const MatchResult& match) const;
  bool doubtful(const MatchResult& match, const Guess& guess, Stamp stamp) const;
  /// Is the better fit of `found` worth its distance from recorded odometry?
  bool outweighs(const MatchResult& found, const MatchResult& match, const Guess& guess) const;
  /// Looks about the guess and, when nothing near fits, all around. @return the motion was found far from the guess.
  bool searched(const Cloud& map_points, const Guess& guess, MatchResult& match, OdometryQuality& quality) const;
  void restartMap(const Cloud& map_points, OdometryQuality& quality);
  MatchOptions matchOptions() const;

  /// @param jumped the motion was found by a search: it says nothing about the velocity of the next step.
  void accept(const Scan& scan, const MatchResult& match, bool jumped, OdometryStep& out);
  void lose(const Scan& scan, const Pose& T_odom_base_guess, const std::string& why, OdometryStep& out);
  Matrix6d stepCovariance(const Matrix6d& information, const Pose& T_previous_base) const;

  Params params_;
  PluginContext context_;

  // The state, all of it saved.
  std::optional<SurfacePyramid> map_;
  double voxel_m_ = 0;
  bool planar_ = false;
  Pose T_odom_base_ = Pose::Identity();
  Pose T_step_ = Pose::Identity();  ///< last motion, T_previous_base
  double step_s_ = 0;               ///< its duration; 0: unknown
  bool moving_known_ = false;       ///< T_step_ was measured
  Stamp stamp_{};
  std::optional<Pose> T_recorded_;  ///< the recording's own pose at stamp_
  double usual_inliers_ = 0;        ///< running level of a good fit's inlier ratio
  int lost_ = 0;                    ///< scans in a row without a fit
  double deskew_evidence_ = 0;      ///< > 0: compensated scans fit better
  int deskew_trials_ = 0;
};

}  // namespace scslam
