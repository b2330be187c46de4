#include <algorithm>

#include "scslam/odometry/scan_to_map.h"

namespace scslam {

void ScanToMapParams::describeShared(ParamVisitor& visitor) {
  visitor.field("voxel_m", voxel_m, "finest map voxel [m]; 0: from the ranges of the first scan", 0.0, 10.0);
  visitor.field("min_range_m", min_range_m, "nearer points are dropped [m]; 0: 1.0 (planar scans 0.1)", 0.0, 100.0);
  visitor.field("max_range_m", max_range_m, "farther points are dropped [m]", 1.0, 1000.0);
  visitor.field("deskew", deskew, "compensate motion within a sweep; auto: where it fits the map better",
                {"auto", "on", "off"});
  visitor.field("use_recorded_odometry", use_recorded_odometry,
                "predict with the recording's own odometry where it fits better than constant velocity");
  visitor.field("max_iterations", max_iterations, "Gauss-Newton iterations per scan", 1, 1000);
}

void ScanToMap::accept(const Scan& scan, const MatchResult& match, bool jumped, OdometryStep& out) {
  const double ratio = match.inlierRatio(), clear = match.clearRatio();
  usual_inliers_ = usual_inliers_ == 0 ? clear : 0.9 * usual_inliers_ + 0.1 * clear;
  lost_ = misfits_ = 0;
  const Pose T_previous_base = T_odom_base_.inverse() * match.T_map_scan;
  if (!jumped) {
    if (moving_known_) learnUnsteadiness(local(T_odom_base_ * predictedStep(scan.stamp), match.T_map_scan));
    T_step_ = T_previous_base;
    step_s_ = secondsBetween(stamp_, scan.stamp);
    moving_known_ = true;
  }
  T_odom_base_ = T_fitted_ = match.T_map_scan;
  stamp_ = scan.stamp;
  T_recorded_ = scan.T_odom_base;

  out.T_odom_base = T_odom_base_;
  out.covariance = stepCovariance(match.information, T_previous_base);
  out.quality.inlier_ratio = ratio;
  out.quality.rmse_m = match.rmse();
  out.quality.iterations = match.iterations;
  out.quality.degenerate_axes = match.degenerate_axes;
}

void ScanToMap::learnUnsteadiness(const Vector6d& miss) {
  constexpr int kRemembered = 20;
  misses_ = std::min(misses_ + 1, kRemembered);
  miss_change_ += ((miss - miss_).cwiseAbs2() - miss_change_) / misses_;
  miss_ = miss;
}

Vector6d ScanToMap::unsteadiness(double sweep_s) const {
  // A sweep is compensated for one velocity. What the velocity does within it bends the scan and moves the pose that
  // fits best, as much as it surprises from one scan to the next; braking and turning in, which change slowly, cancel
  // in the change of the miss. Measured on the simulated scenarios (compare's NEES), whose vehicles have springs and
  // roads of 1-3 cm.
  constexpr double kPart = 0.2;
  const double share = step_s_ > 0 ? std::min(sweep_s / step_s_, 1.0) : 1.0;
  Vector6d variances = kPart * share * share * miss_change_;
  if (planar_) variances.segment<3>(2).setZero();
  return variances;
}

void ScanToMap::lose(const Scan& scan, const Pose& T_odom_base_guess, const std::string& why, OdometryStep& out) {
  Pose T_previous_base = Pose::Identity();
  double blind_s = 0;
  twist_.reset();
  if (map_) {
    const bool recorded = params_.use_recorded_odometry && T_recorded_ && scan.T_odom_base;
    if (!recorded) blind_s = std::max(0.0, secondsBetween(stamp_, scan.stamp) - kFollowedSteps * step_s_);
    T_previous_base = T_odom_base_.inverse() * T_odom_base_guess;
    T_odom_base_ = T_odom_base_guess;
    stamp_ = scan.stamp;
    T_recorded_ = scan.T_odom_base;
    lost_ = blind_s > 0 ? std::max(lost_ + 1, kAdriftAfter) : lost_ + 1;
  }
  out.T_odom_base = T_odom_base_;
  out.covariance = stepCovariance(Matrix6d::Zero(), T_previous_base, blind_s);
  out.quality.ok = false;
  out.quality.inlier_ratio = 0;
  out.quality.degenerate_axes = scan.planar ? 3 : 6;
  out.quality.note = why;
}

Matrix6d ScanToMap::stepCovariance(const Matrix6d& information, const Pose& T_previous_base, double blind_s) const {
  // Directions without information keep what constant velocity is worth: half the motion itself. Beyond what it follows
  // the robot may have gone on, turned, or been carried at a walk.
  const double speed_mps = step_s_ > 0 ? T_step_.translation().norm() / step_s_ : 0;
  const double sigma_m = 0.1 + 0.5 * T_previous_base.translation().norm() + (speed_mps + 1) * blind_s;
  const double sigma_rad = std::min(0.05 + 0.5 * rotationAngle(T_previous_base) + 0.3 * blind_s, M_PI);
  Vector6d prior;
  prior << Eigen::Vector3d::Constant(1 / (sigma_m * sigma_m)), Eigen::Vector3d::Constant(1 / (sigma_rad * sigma_rad));
  if (planar_) {
    const OffPlane off = offPlane(T_previous_base);
    prior(2) = 1 / (off.z_m * off.z_m);
    prior(3) = prior(4) = 1 / (off.tilt_rad * off.tilt_rad);
  }
  Matrix6d total = information;
  total.diagonal() += prior;
  Matrix6d covariance = total.inverse();
  covariance.diagonal().array() += 1e-8;
  return 0.5 * (covariance + covariance.transpose());
}

void ScanToMap::save(ByteWriter& state) const {
  state.put(voxel_m_);
  state.put(planar_);
  state.put(T_odom_base_);
  state.put(T_fitted_);
  state.put(T_step_);
  state.put(step_s_);
  state.put(moving_known_);
  state.put(twist_.has_value());
  state.put(twist_.value_or(Vector6d::Zero()));
  state.put(miss_);
  state.put(miss_change_);
  state.put(misses_);
  state.put(static_cast<std::int64_t>(stamp_.time_since_epoch().count()));
  state.put(T_recorded_.has_value());
  state.put(T_recorded_.value_or(Pose::Identity()));
  state.put(usual_inliers_);
  state.put(lost_);
  state.put(misfits_);
  state.put(deskew_evidence_);
  state.put(deskew_trials_);
  state.put(std::uint64_t{first_.size()});
  for (const Cloud& part : first_) saveCloud(state, part);
  state.put(map_.has_value());
  if (map_) saveMap(state);
}

void ScanToMap::load(ByteReader& state) {
  state.get(voxel_m_);
  state.get(planar_);
  state.get(T_odom_base_);
  state.get(T_fitted_);
  state.get(T_step_);
  state.get(step_s_);
  state.get(moving_known_);
  const bool compensated = state.get<bool>();
  Vector6d twist;
  state.get(twist);
  twist_ = compensated ? std::optional(twist) : std::nullopt;
  state.get(miss_);
  state.get(miss_change_);
  state.get(misses_);
  stamp_ = Stamp(Stamp::duration(state.get<std::int64_t>()));
  const bool recorded = state.get<bool>();
  Pose T_recorded;
  state.get(T_recorded);
  T_recorded_ = recorded ? std::optional(T_recorded) : std::nullopt;
  state.get(usual_inliers_);
  state.get(lost_);
  state.get(misfits_);
  state.get(deskew_evidence_);
  state.get(deskew_trials_);
  first_.clear();
  for (auto parts = state.get<std::uint64_t>(); parts > 0; --parts) loadCloud(state, first_.emplace_back());
  map_.reset();
  if (!state.get<bool>()) return;
  if (!(voxel_m_ > 0)) throw inputError("odometry: a saved map without a voxel size");
  clearMap();
  loadMap(state);
}

}  // namespace scslam
