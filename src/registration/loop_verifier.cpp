#include "scslam/registration/loop_verifier.h"

#include <algorithm>

#include "scslam/core/scan_match.h"

namespace scslam {
namespace {

std::size_t nearestTo(const Eigen::Vector3d& p_target, const std::vector<Pose>& T_target_base) {
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < T_target_base.size(); ++i)
    if ((T_target_base[i].translation() - p_target).squaredNorm() <
        (T_target_base[nearest].translation() - p_target).squaredNorm())
      nearest = i;
  return nearest;
}

}  // namespace

LoopVerifier::LoopVerifier(std::unique_ptr<Registration> registration, const LoopGateParams& gates,
                           const Eigen::Vector3d& viewpoint_base)
    : registration_(std::move(registration)), gates_(gates), viewpoint_(viewpoint_base.cast<float>()) {}

void LoopVerifier::setTarget(LoopTarget target) {
  registration_->setTarget(target.submap);
  target_ = std::move(target);
  target_patches_.reset();
}

Verification LoopVerifier::verify(const Cloud& query, std::vector<Pose> T_target_query_guesses,
                                  const OdometryPrediction& predicted, bool planar) {
  Verification verification;
  T_target_query_guesses.push_back(predicted.T_match_query);
  Choice choice =
      chosenByOdometry(registration_->align(query, T_target_query_guesses, planar), predicted, planar, gates_);
  verification.registration = std::move(choice.result);
  verification.odometry_mahalanobis2 = choice.odometry_mahalanobis2;
  verification.refusal = refusal(verification.registration, gates_);
  if (verification.refusal.empty()) verification.refusal = choice.refusal;
  if (!verification.refusal.empty()) return verification;
  verification.free_space = freeSpace(query, verification.registration.T_target_source, planar);
  verification.refusal = refusal(*verification.free_space, gates_);
  if (verification.refusal.empty() && gates_.quality.on)
    verification.refusal =
        refusal(alignmentFeatures(query, target_.submap, verification.registration, gates_.quality.radius_m, planar),
                gates_.quality);
  return verification;
}

FreeSpace LoopVerifier::freeSpace(const Cloud& query, const Pose& T_target_query, bool planar) {
  constexpr std::size_t kPatchPoints = 100000;  // neighbouring scans show the same walls
  const double patch_m = patchSize(query, planar);
  const float margin_m = std::max(0.5f, static_cast<float>(patch_m));
  FreeSpace result;
  if (target_.clouds.empty()) return result;
  if (!target_patches_) target_patches_ = patchesOf(thinned(target_.submap, kPatchPoints), patch_m, planar);
  const SightFigures of_submap =
      sightOf(RangeImage(query, viewpoint_, planar), *target_patches_, T_target_query.inverse(), margin_m);
  result.target_overlap = of_submap.explained();
  result.through_submap = of_submap.throughWalls();

  const std::size_t near = nearestTo(T_target_query.translation(), target_.T_target_base);
  const RangeImage view(*target_.clouds[near], viewpoint_, planar);
  const Pose T_near_query = target_.T_target_base[near].inverse() * T_target_query;
  result.through_scan = sightOf(view, patchesOf(query, patch_m, planar), T_near_query, margin_m).throughWalls();
  return result;
}

}  // namespace scslam
