// Long-term data association, second half: the 6-D constraint between a scan and a submap.
#pragma once
#include <vector>

#include "scslam/core/cloud.h"
#include "scslam/core/registry.h"

namespace scslam {

struct RegistrationResult {
  Pose T_target_source = Pose::Identity();
  Matrix6d hessian = Matrix6d::Zero();  ///< information of T_target_source (tangent of core/pose.h, frame source),
                                        ///< residual variance divided out; next to nothing in unfixed directions
  Matrix6d unfixed = Matrix6d::Zero();  ///< takes the part of a tangent vector that the overlap does not fix
  int degenerate_axes = 0;              ///< how many such directions there are
  std::size_t points = 0;               ///< of the source that were used
  bool converged = false;
  int iterations = 0;
  double inlier_ratio = 0;  ///< of the source points that found a surface of the target, the share that lies on it
  double explained = 0;     ///< share of all source points that lie on a surface of the target
  double overlap = 0;       ///< share of source points (within the target's extent) that lie in occupied target space
  double rmse_m = 0;        ///< of the inliers, along the surface normal
  double fit = 1;           ///< of a rival: its fit relative to the best pose's
  std::vector<RegistrationResult> rivals;  ///< clearly different poses that fit nearly as well, best first, few
};

/// Plug-in interface of registration/methods.
class Registration {
 public:
  static constexpr const char* kKind = "registration method";
  virtual ~Registration() = default;
  /// Builds whatever the method needs of the target; several align() calls may follow, for any source.
  virtual void setTarget(const Cloud& target) = 0;
  /// The best fit of all guesses (at least one), the place recogniser's first. Also tried: the first guess turned by
  /// half a turn, which is how a street looks alike from both ends.
  /// @param planar only x, y and yaw are estimated (2-D data). Never throws for empty or degenerate clouds: converged =
  /// false.
  virtual RegistrationResult align(const Cloud& source, const std::vector<Pose>& T_target_source_guesses,
                                   bool planar) = 0;
  RegistrationResult align(const Cloud& source, const Pose& T_target_source_guess, bool planar) {
    return align(source, std::vector<Pose>{T_target_source_guess}, planar);
  }
};
SCSLAM_DECLARE_REGISTRY(Registration);

}  // namespace scslam
