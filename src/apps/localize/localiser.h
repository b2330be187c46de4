// Where in a saved map is the robot? Without a start pose: recognised, registered, confirmed; then tracked.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scslam/apps/saved_map.h"
#include "scslam/odometry/odometry.h"
#include "scslam/pipeline/loop_trial.h"

namespace scslam {

struct LocalizeParams : ParamSetOf<LocalizeParams> {
  int confirmations = 2;
  double agree_m = 1, agree_deg = 5;
  int lost_after_scans = 10;
  double lost_after_m = 20;
  int restart_after_scans = 3;
  void describe(ParamVisitor& v) override;
};

enum class WhereState {
  kSearching,  ///< no pose
  kTracking,   ///< this scan was registered against the map
  kCoasting,   ///< it was not; the pose is the last one and odometry
};
const char* nameOf(WhereState state);

struct Whereabouts {
  WhereState state = WhereState::kSearching;
  Pose T_map_base = Pose::Identity();      ///< unless searching
  Matrix6d covariance = Matrix6d::Zero();  ///< of it, tangent of core/pose.h, frame base
  std::optional<KeyframeId> keyframe;      ///< of the map, against whose surroundings the scan was registered
  bool first_fix = false;                  ///< found just now, for the first time or again
  bool odometry_doubted = false;           ///< two findings in a row, but odometry says they are elsewhere: it slipped
  std::string note;                        ///< why not, or what happened
};

class Localiser {
 public:
  /// @param map outlives this; its base frame is the one poses speak of.
  Localiser(const SavedMap& map, const SlamParams& slam, const LocalizeParams& params, const PluginContext& context);

  /// Forgets where it was, not the map.
  void reset();
  /// @param step of the front-end, frame base.
  Whereabouts step(const OdometryStep& step);
  /// The front-end began anew with the scan of the last step(): where its odometry frame puts that scan.
  void odometryRestarted(const Pose& T_odom_base);
  bool searching() const { return !tracked_; }

 private:
  struct Fix {
    Pose T_map_base;
    Matrix6d covariance;
    KeyframeId keyframe;
  };
  struct Pending {
    Pose T_map_base, T_odom_base;
    int agreeing = 0;
    bool now = false;  ///< found in the last step
  };
  struct Tracked {
    Pose T_map_base, T_odom_base;
    Matrix6d covariance;
    int misses = 0;
    double since_match_m = 0;
  };
  std::optional<Fix> recognised(const Keyframe& here, const OdometryStep& step, const Cloud& thinned,
                                std::string& note);
  bool confirmed(const Fix& fix, const Pose& T_odom_base);
  Whereabouts search(const OdometryStep& step, const Cloud& thinned);
  Whereabouts track(const OdometryStep& step, const Cloud& thinned);
  KeyframeId nearestTo(const Eigen::Vector3d& p_map) const;
  void setTarget(KeyframeId match);

  const SavedMap& map_;
  SlamParams slam_;
  LocalizeParams params_;
  bool planar_;
  std::vector<std::unique_ptr<PlaceRecogniser>> recognisers_;
  LoopTrial trial_;
  std::optional<Pending> pending_;
  std::optional<Tracked> tracked_;
};

}  // namespace scslam
