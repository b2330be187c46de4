// Short-term data association (paper, Sec. III-B1): how did the robot move since the last scan?
#pragma once
#include <optional>
#include <string>

#include "scslam/core/bytes.h"
#include "scslam/core/registry.h"
#include "scslam/sensor/scan.h"

namespace scslam {

struct OdometryQuality {
  bool ok = true;  ///< false: the scan could not be used or the motion could not be found; the pose is predicted
  double inlier_ratio = 1.0;  ///< matched share of the source points
  double rmse_m = 0.0;        ///< of the matched points, along the surface normal
  int iterations = 0;
  int degenerate_axes = 0;  ///< number of directions of motion the scan does not fix (0..6)
  std::string note;         ///< one line when something was unusual ("recovered by rotation search")
};

struct OdometryStep {
  Pose T_odom_base = Pose::Identity();  ///< at the scan's stamp
  /// Covariance of the step T_previous_base, tangent of core/pose.h, in frame base: of the errors that stay, which add
  /// up along the way. The first step has zero.
  Matrix6d covariance = Matrix6d::Zero();
  /// Besides, variances of the errors that pass: a scan that was bent by the robot's shaking lies wrong itself, those
  /// after it are not the worse for it. The error of the step has covariance + diag(passing).
  Vector6d passing = Vector6d::Zero();
  Cloud cloud;  ///< the scan's points in frame base, motion-compensated to the stamp, finite, within range
  OdometryQuality quality;
};

/// A front-end. Plug-in interface of odometry/frontends. Deterministic: the same scans give the same bits.
class Odometry {
 public:
  static constexpr const char* kKind = "odometry front-end";
  virtual ~Odometry() = default;
  /// @param scan in time order. An empty or useless scan gives quality.ok == false, never an exception.
  /// @throw inputError only when the front-end's own input is missing (no pose for this scan).
  virtual OdometryStep step(const Scan& scan) = 0;
  /// Called once before the first step: how many scans there will be (if known) and T_base_reference of the source.
  virtual void begin(std::optional<std::size_t> /*scan_count*/, const Pose& /*T_base_reference*/) {}
  /// The graph moved the newest keyframe: T_map_odom changed. A front-end may ignore it (default).
  virtual void correct(const Pose& /*T_map_odom*/) {}
  /// Everything the next step() depends on, and back: a run continued from it gives the same bits.
  virtual void save(ByteWriter& state) const = 0;
  virtual void load(ByteReader& state) = 0;
};
SCSLAM_DECLARE_REGISTRY(Odometry);

}  // namespace scslam
