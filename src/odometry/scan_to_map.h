// What every front-end that matches a scan with a local map shares; a method only says what it takes from a scan and
// how it fits that to its map.
//
// Constant velocity (or the recording's own odometry) predicts, a robust kernel that follows the residuals decides, and
// a fit clearly worse than the usual one starts a search over headings and shifts: a turn that the prediction does not
// know of is found again instead of being driven through. A scan that fits nowhere is said to be lost, its motion is
// predicted with a wide covariance, and after some in a row the map starts anew.
#pragma once
#include <optional>

#include "scslam/core/scan_match.h"
#include "scslam/odometry/odometry.h"

namespace scslam {

/// Parameters of all these front-ends.
struct ScanToMapParams {
  double voxel_m = 0;      ///< finest map voxel; 0: from the first scan's ranges
  double min_range_m = 0;  ///< nearer points are the robot itself; 0: 1.0, 0.1 for planar scans
  double max_range_m = 100;
  std::string deskew = "auto";
  bool use_recorded_odometry = true;
  int max_iterations = 30;
  void describeShared(ParamVisitor& visitor);
};

class ScanToMap : public Odometry {
 public:
  OdometryStep step(const Scan& scan) override;
  void save(ByteWriter& state) const final;
  void load(ByteReader& state) final;

 protected:
  static constexpr int kLevels = 3;             ///< of the map's pyramid
  static constexpr int kAdriftAfter = 5;        ///< scans without a fit in a row: the prediction has no claim any more
  static constexpr double kFollowedSteps = 10;  ///< constant velocity is believed for so many steps without a scan

  /// What a method takes from a scan, frame base, with dt where the scan has it. Element 0 is the surface points that
  /// the map of planes is made of, starts are compared by and a search looks for; the others are the method's own.
  using Features = std::vector<Cloud>;

  struct Guess {
    Pose T_odom_base;
    Matrix6d information;  ///< of the step, from recorded odometry; zero: only a place to start from
    bool recorded() const { return !information.isZero(0.0); }
  };

  ScanToMap(const ScanToMapParams& params, const PluginContext& context) : params_(params), context_(context) {}

  /// @param cloud frame base, finite, in range.
  /// @return empty, or why the scan is of no use; the step is then predicted.
  /// @throw inputError when no scan of this kind can be used by the method (only before there is a map).
  virtual std::string extract(const Cloud& cloud, const Scan& scan, Features& features) = 0;
  /// Brings what was seen at the points' own instants to the scan's stamp. Default: deskew().
  /// @param twist of the base during the sweep (deskew.h).
  virtual void compensate(Cloud& cloud, const Vector6d& twist) const;
  /// Do sweeps take so long that no robot stops between two of them?
  virtual bool slowSweeps() const { return false; }
  /// A fit with a smaller share of inliers is chance.
  virtual double leastInliers() const { return 0.1; }
  /// Must the map's first sweep, taken before any velocity is known, be compensated when it is?
  virtual bool compensatesFirst() const { return true; }
  /// What planar data says nothing of: one sigma of the step's height, roll and pitch.
  struct OffPlane {
    double z_m = 1e-4, tilt_rad = 1e-4;
  };
  virtual OffPlane offPlane(const Pose& /*T_previous_base*/) const { return {}; }
  /// A better start than the guess (scan-to-scan matching, say). Default: the guess.
  virtual Pose closer(const Features& /*features*/, const Guess& guess) const { return guess.T_odom_base; }
  /// The fit of the features to the map from T_start; guess.information pulls towards the guess.
  virtual MatchResult match(const Features& features, const Guess& guess, const Pose& T_start) const = 0;
  /// Adds the features, placed by T_odom_base, to the map. Default: element 0 to the planes.
  virtual void insert(const Features& features, const Pose& T_odom_base);
  /// An empty map of the method's own, made when voxelSize() is known.
  virtual void clearMap() { map_.emplace(voxel_m_, kLevels, SurfelRules::rough(planar_)); }
  virtual void forgetBeyond(const Eigen::Vector3d& centre, double radius_m);
  virtual void saveMap(ByteWriter& state) const { map_->save(state); }
  virtual void loadMap(ByteReader& state) { map_->load(state); }  ///< after clearMap()

  double voxelSize() const { return voxel_m_; }
  bool planar() const { return planar_; }
  bool started() const { return map_.has_value(); }
  const SurfacePyramid& planes() const { return *map_; }
  ThreadPool& threads() const { return context_.threads; }
  const Pose& lastPose() const { return T_odom_base_; }
  /// Iterations, levels, noise and gates for this map; the guess's information is set.
  MatchOptions matchOptions(const Guess& guess) const;
  /// One point per voxel of voxel_m, with its time; small clouds whole.
  static Cloud thin(const Cloud& cloud, double voxel_m);

 private:
  /// A scan made ready: what is handed on, what is put into the map and matched.
  struct Prepared {
    Cloud cloud;             ///< frame base, in range, finite
    Features raw, features;  ///< before and after deskewing
  };
  struct Fit {
    MatchResult match;
    Vector6d twist = Vector6d::Zero();  ///< used for deskewing
    bool deskewed = false;
  };
  /// How far a search looks: an error of recorded odometry, of constant velocity, or a half turn.
  enum class Reach { kStep, kNear, kFar };

  std::string prepare(const Scan& scan, Prepared& prepared);
  void start(const Scan& scan, Prepared& prepared, OdometryStep& out);
  void follow(const Scan& scan, Prepared& prepared, OdometryStep& out);
  Pose predictedStep(Stamp stamp) const;
  Guess bestGuess(const Scan& scan, const Cloud& source) const;
  Matrix6d recordedInformation(const Pose& T_step) const;
  Vector6d twistOf(const Pose& T_previous_base, Stamp stamp) const;
  bool moreThanNoise(const Vector6d& twist, double sweep_s) const;

  bool canDeskew(const Prepared& prepared, const Scan& scan) const;
  /// The map of the first sweep anew, compensated with the velocity that the second one shows, and the second's fit to
  /// it.
  void beginAgain(Prepared& prepared, const Scan& scan, Fit& fit);
  Fit fitScan(Prepared& prepared, const Scan& scan, const Guess& guess);
  Fit fitDeskewed(Prepared& prepared, const Scan& scan, const Guess& guess) const;
  MatchResult matchFromGuess(const Features& features, const Guess& guess) const;
  /// The method's own fit from the best place that a search over the planes finds.
  MatchResult search(const Features& features, const Pose& T_odom_base_guess, Reach reach) const;
  /// Inlier ratio as a share of the usual one; 0 when there are too few.
  double share(const MatchResult& match) const;
  /// Too long without a fit, or without a scan, to know where the robot might be.
  bool adrift(const Guess& guess, Stamp stamp) const;
  bool doubtful(const MatchResult& match, const Guess& guess, Stamp stamp) const;
  /// Is the better fit of `found` worth its distance from recorded odometry?
  bool outweighs(const MatchResult& found, const MatchResult& match, const Guess& guess) const;
  /// Looks about the guess and, when nothing near fits, all around. @return the motion was found far from the guess.
  bool searched(const Features& features, const Guess& guess, Stamp stamp, MatchResult& match,
                OdometryQuality& quality) const;
  void restartMap(const Prepared& prepared, OdometryQuality& quality);

  /// @param jumped the motion was found by a search: it says nothing about the velocity of the next step.
  void accept(const Scan& scan, const MatchResult& match, bool jumped, OdometryStep& out);
  void lose(const Scan& scan, const Pose& T_odom_base_guess, const std::string& why, OdometryStep& out);
  /// @param miss what the fit is off constant velocity's prediction (frame base).
  void learnUnsteadiness(const Vector6d& miss);
  /// Variances of what the robot's shaking within a sweep of this length does to a step.
  Vector6d unsteadiness(double sweep_s) const;
  /// @param blind_s longer than kFollowedSteps without a scan.
  Matrix6d stepCovariance(const Matrix6d& information, const Pose& T_previous_base, double blind_s = 0) const;

  ScanToMapParams params_;
  PluginContext context_;

  // The state, all of it saved.
  std::optional<SurfacePyramid> map_;
  double voxel_m_ = 0;
  bool planar_ = false;
  Features first_;  ///< the map's only scan as it was seen; empty once a velocity is known
  Pose T_odom_base_ = Pose::Identity();
  Pose T_fitted_ = Pose::Identity();         ///< where the last scan was that fitted
  Pose T_step_ = Pose::Identity();           ///< last motion, T_previous_base
  double step_s_ = 0;                        ///< its duration; 0: unknown
  bool moving_known_ = false;                ///< T_step_ was measured
  std::optional<Vector6d> twist_;            ///< that the last sweep was compensated for, if it was
  Vector6d miss_ = Vector6d::Zero();         ///< of constant velocity at the last scan
  Vector6d miss_change_ = Vector6d::Zero();  ///< mean square of its change from scan to scan
  int misses_ = 0;                           ///< that this is the mean of
  Stamp stamp_{};
  std::optional<Pose> T_recorded_;  ///< the recording's own pose at stamp_
  double usual_inliers_ = 0;        ///< running level of a good fit's inlier ratio
  int lost_ = 0;                    ///< scans in a row that gave no motion
  int misfits_ = 0;                 ///< of them, scans that were usable but fitted nowhere
  double deskew_evidence_ = 0.1;    ///< > 0: compensated scans fit better; at first: who gives times means them
  int deskew_trials_ = 0;
};

}  // namespace scslam
