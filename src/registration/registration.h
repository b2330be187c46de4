// Long-term data association, second half: the 6-D constraint between a scan and a submap.
#pragma once
#include "scslam/core/cloud.h"
#include "scslam/core/registry.h"

namespace scslam {

struct RegistrationResult {
  Pose T_target_source = Pose::Identity();
  Matrix6d hessian = Matrix6d::Zero();  ///< information of T_target_source (tangent of core/pose.h, frame source),
                                        ///< residual variance divided out
  bool converged = false;
  int iterations = 0;
  double inlier_ratio = 0;  ///< of the source points that found a surface of the target, the share that lies on it
  double overlap = 0;       ///< share of source points (within the target's extent) that lie in occupied target space
  double rmse_m = 0;        ///< of the inliers, along the surface normal
  int degenerate_axes = 0;  ///< directions the overlap does not fix
};

/// Plug-in interface of registration/methods.
class Registration {
 public:
  static constexpr const char* kKind = "registration method";
  virtual ~Registration() = default;
  /// Builds whatever the method needs of the target; several align() calls may follow.
  virtual void setTarget(const Cloud& target) = 0;
  /// @param planar only x, y and yaw are estimated (2-D data). Never throws for empty or degenerate clouds: converged =
  /// false.
  virtual RegistrationResult align(const Cloud& source, const Pose& T_target_source_guess, bool planar) = 0;
};
SCSLAM_DECLARE_REGISTRY(Registration);

}  // namespace scslam
