// A loop candidate on trial: registered against the scans around the matched place, then judged by every gate.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scslam/registration/free_space.h"
#include "scslam/registration/loop_gates.h"

namespace scslam {

/// The scans around a place.
struct LoopTarget {
  Cloud submap;                                      ///< all of them, frame target
  std::vector<Pose> T_target_base;                   ///< where each was taken
  std::vector<std::shared_ptr<const Cloud>> clouds;  ///< each in its own base frame
};

struct Verification {
  RegistrationResult registration;
  std::optional<FreeSpace> free_space;  ///< compared only when the gates before let it pass
  double odometry_mahalanobis2 = 0;
  std::string refusal;  ///< empty: a loop
};

class LoopVerifier {
 public:
  /// @param viewpoint_base where the sensor sits in the base frame.
  LoopVerifier(std::unique_ptr<Registration> registration, const LoopGateParams& gates,
               const Eigen::Vector3d& viewpoint_base);

  /// Any number of verify() calls may follow, for other scans and other guesses; what they need is built once.
  void setTarget(LoopTarget target);

  /// @param query frame base; @param T_target_query_guesses at least one, the place recogniser's first. Odometry's
  /// prediction is tried as well. @param planar 2-D data.
  Verification verify(const Cloud& query, std::vector<Pose> T_target_query_guesses, const OdometryPrediction& predicted,
                      bool planar);

 private:
  FreeSpace freeSpace(const Cloud& query, const Pose& T_target_query, bool planar);

  std::unique_ptr<Registration> registration_;
  LoopGateParams gates_;
  Eigen::Vector3f viewpoint_;
  LoopTarget target_;
  std::optional<Patches> target_patches_;  ///< frame target; built when first needed
};

}  // namespace scslam
