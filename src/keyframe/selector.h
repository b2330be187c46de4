// When does a scan become a place of the graph?
#pragma once
#include "scslam/core/bytes.h"
#include "scslam/core/params.h"
#include "scslam/keyframe/keyframe.h"

namespace scslam {

struct KeyframeParams : ParamSetOf<KeyframeParams> {
  double distance_m = 1.0;
  double rotation_deg = 15.0;
  void describe(ParamVisitor& visitor) override;
};

/// A keyframe is due when the robot is distance_m or rotation_deg away from the last keyframe. The displacement counts,
/// not the path, so odometry jitter while standing never adds up to a keyframe.
class KeyframeSelector {
 public:
  explicit KeyframeSelector(const KeyframeParams& params) : params_(params) {}

  /// Takes every scan's pose in order. @param step_covariance of the motion since the previous scan, frame base.
  /// @return true when this scan is to be a keyframe; then fill(keyframe) gives what accumulated since the last one.
  bool isDue(const Pose& T_odom_base, const Matrix6d& step_covariance);
  /// Makes the last pose given to isDue() the newest keyframe: sets T_odom_base, travelled_m and step_covariance.
  void accept(Keyframe& keyframe);

  void save(ByteWriter& state) const;
  void load(ByteReader& state);

 private:
  KeyframeParams params_;
  bool first_ = true;
  Pose T_odom_keyframe_ = Pose::Identity(), T_odom_base_ = Pose::Identity();
  Matrix6d covariance_ = Matrix6d::Zero();  ///< of T_keyframe_base
  double travelled_m_ = 0;                  ///< at the last keyframe
};

}  // namespace scslam
