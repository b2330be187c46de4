#include "scslam/odometry/imu_odometry.h"

#include <algorithm>
#include <cmath>

#include "scslam/core/deskew.h"

namespace scslam {
namespace {

// Shares of the usual inlier ratio: below kPoor the surroundings of the guess are searched, below kLost the scan is
// given up; a far place must fit nearly as well as usual.
constexpr double kPoorShare = 0.7, kLostShare = 0.4, kFarShare = 0.75;
constexpr double kNearBetter = 1.15, kFarBetter = 1.3;  // than the fit at the guess
constexpr double kFarPrecision = 0.75;                  // inliers among the matched points of a far place
// Scans without a fit in a row, or so long without a scan: constant speed has no claim any more.
constexpr int kAdriftAfter = 5;
constexpr double kAdriftAfterS = 2;

bool precise(const MatchResult& match) { return match.system.inliers >= kFarPrecision * match.system.matched; }

}  // namespace

ImuOdometry::ImuOdometry(const Params& params, const PluginContext& context, std::unique_ptr<ImuEstimator> estimator,
                         std::string name)
    : params_(params),
      context_(context),
      name_(std::move(name)),
      map_(params.map, context),
      stream_(params.max_imu_gap_s),
      estimator_(std::move(estimator)) {
  stream_.time_offset_s = params.imu_time_offset_s;
  estimator_->begin(Pose::Identity(), Pose::Identity(), {0, 0, -params.gravity_m_s2}, Eigen::Vector3d::Zero(), {});
}

OdometryStep ImuOdometry::step(const Scan& scan) {
  OdometryStep out;
  note_.clear();
  out.cloud = map_.inRange(scan);
  const bool useless = map_.tooFew(out.cloud, scan.planar), first = !map_.started();
  takeReadings(scan);
  if (first && useless) {
    lose(scan, fmt::format("only {} usable points", out.cloud.size()), out);
    return out;
  }
  if (first) {
    map_.start(out.cloud, scan.planar);
    stamp_ = scan.stamp;
    T_recorded_ = scan.T_odom_base;
    const Cloud thin = map_.thin(out.cloud);
    Cloud compensated = thin;
    const SweepMotion sweep = sweepOf(scan, sweepDuration(thin), *estimator_);
    deskew(compensated, sweep);
    deskew(out.cloud, sweep);
    map_.insert(compensated, estimator_->basePose());
    if (params_.deskew && thin.hasTime() && !scan.deskewed) first_ = thin;
    T_previous_ = T_fitted_ = out.T_odom_base = estimator_->basePose();
    out.quality.note = note_;
    return out;
  }

  predict(scan);
  measureRecorded(scan);
  if (useless) {
    lose(scan, fmt::format("only {} usable points", out.cloud.size()), out);
    return out;
  }
  const Cloud thin = map_.thin(out.cloud);
  Fit found = fit(scan, thin);
  if (!first_.empty() && map_.share(found.match) >= kLostShare) beginAgain(scan, thin, found);
  deskew(out.cloud, found.sweep);
  if (map_.share(found.match) < kLostShare) {
    lose(scan,
         fmt::format("the scan does not fit the map (inliers {:.2f}, usually {:.2f})", found.match.inlierRatio(),
                     map_.usualInliers()),
         out);
    if (lost_ == patience()) {
      map_.restart();
      map_.insert(found.thin, estimator_->basePose());
      T_fitted_ = estimator_->basePose();
      lost_ = 0;
      out.quality.note += "; local map restarted";
    }
    return out;
  }
  accept(scan, found, out);
  map_.insert(found.thin, estimator_->basePose());
  return out;
}

// ---- the fit ----

void ImuOdometry::measureRecorded(const Scan& scan) {
  by_wheels_ = false;
  if (!params_.use_recorded_odometry || !T_recorded_ || !scan.T_odom_base) return;
  const Pose T_step = T_recorded_->inverse() * *scan.T_odom_base;
  if (!isRigid(T_step)) return;
  by_wheels_ = true;
  // Wheels slip and know nothing of slopes: a share of the way, a third of the turn, and a floor.
  const double sigma_m = 0.01 + 0.02 * T_step.translation().norm();
  const double sigma_rad = 0.03 + 0.2 * rotationAngle(T_step), sigma_up_m = 0.05 + 0.2 * T_step.translation().norm();
  Vector6d sigma;
  sigma << sigma_m, sigma_m, sigma_up_m, Eigen::Vector3d::Constant(sigma_rad);
  estimator_->measureStep(T_step, sigma.cwiseAbs2().cwiseInverse().asDiagonal());
}

ImuOdometry::Fit ImuOdometry::fit(const Scan& scan, const Cloud& thin_raw) {
  const double sweep_s = sweepDuration(thin_raw);
  if (!thin_raw.hasTime() && !scan.deskewed && params_.deskew && !scan.planar)
    say(kNoTimes,
        "the scans have no time per point: motion within a sweep is not compensated (sensor.model may give times)");
  Fit fit;
  fit.sweep = sweepOf(scan, sweep_s, *estimator_);
  fit.thin = thin_raw;
  deskew(fit.thin, fit.sweep);
  const Pose T_predicted = estimator_->basePose();
  const Matrix6d information = speed_known_ || inertial_ ? estimator_->poseInformation() : Matrix6d::Zero().eval();
  fit.match = map_.match(fit.thin, T_predicted, information);
  if (adrift(scan))
    searchAdrift(fit.thin, fit);
  else if (map_.share(fit.match) < kPoorShare || !speed_known_)
    searchAbout(fit.thin, fit);
  if (fit.jumped) return fit;

  // The speed this pose speaks of may compensate the sweep differently; with a filter that has settled it does not.
  const Vector6d correction = local(T_predicted, fit.match.T_map_scan);
  const double dt = secondsBetween(stamp_, scan.stamp), share_of_sweep = dt > 0 ? sweep_s / dt : 0;
  if (share_of_sweep * correction.head<3>().norm() < 0.04 * map_.voxel() || map_.share(fit.match) < kLostShare)
    return fit;
  const auto settled = estimator_->clone();
  settled->measurePose(fit.match.T_map_scan, fit.match.information);
  const SweepMotion sweep = sweepOf(scan, sweep_s, *settled);
  if (sweep.poses.empty()) return fit;
  fit.sweep = sweep;
  fit.thin = thin_raw;
  deskew(fit.thin, fit.sweep);
  const Pose T_start = fit.match.T_map_scan;
  if (fit.searched) {
    fit.match = map_.match(fit.thin, T_start, Matrix6d::Zero());
  } else {
    fit.match = map_.match(fit.thin, T_predicted, information);
  }
  return fit;
}

void ImuOdometry::beginAgain(const Scan& scan, const Cloud& thin_raw, Fit& found) {
  constexpr int kRounds = 4;
  const double dt = secondsBetween(stamp_, scan.stamp);
  for (int round = 0; round < kRounds && dt > 1e-4 && dt < 2.0 && !found.jumped; ++round) {
    const Pose T_step = T_previous_.inverse() * found.match.T_map_scan;
    Cloud compensated = first_;
    deskew(compensated, local(Pose::Identity(), T_step) / dt);
    map_.restart();
    map_.insert(compensated, T_previous_);
    found = fit(scan, thin_raw);
  }
  first_.clear();
}

/// Looks around when the fit is poor: nearby, and when nothing near fits, farther the longer nothing did.
void ImuOdometry::searchAbout(const Cloud& thin, Fit& fit) const {
  const MatchResult near = map_.search(thin, estimator_->basePose(), 12 * map_.voxel(), 0.3);
  if (near.meanScore() > kNearBetter * fit.match.meanScore()) fit.match = near, fit.searched = true;
  if (map_.share(fit.match) >= (by_imu_ ? kLostShare : kPoorShare)) return;
  const MatchResult far = map_.search(thin, estimator_->basePose(), 12 * map_.voxel(), M_PI);
  if (!precise(far) || map_.share(far) < kFarShare || far.inlierRatio() < kFarBetter * fit.match.inlierRatio()) return;
  fit.match = far, fit.searched = true;
}

bool ImuOdometry::adrift(const Scan& scan) const {
  return !by_imu_ && !by_wheels_ && (lost_ >= kAdriftAfter || secondsBetween(stamp_, scan.stamp) > kAdriftAfterS);
}

/// It may have gone on or stopped: the best fit about both places counts, not the first that is good enough.
void ImuOdometry::searchAdrift(const Cloud& thin, Fit& fit) const {
  for (const Pose& T_odom_base : {estimator_->basePose(), T_fitted_}) {
    const MatchResult far = map_.search(thin, T_odom_base, 12 * map_.voxel(), M_PI);
    if (precise(far) && far.meanScore() > fit.match.meanScore()) fit.match = far;
  }
  fit.searched = fit.jumped = true;
}

int ImuOdometry::patience() const { return inertial_ && by_imu_ ? 50 : 5; }

Matrix6d ImuOdometry::reportedCovariance() const {
  Matrix6d C = estimator_->stepCovariance();
  if (by_imu_) C *= estimator_->shareOfStep();
  C.diagonal().array() += 1e-8;
  return C;
}

void ImuOdometry::accept(const Scan& scan, const Fit& fit, OdometryStep& out) {
  map_.note(fit.match);
  lost_ = 0;
  estimator_->measurePose(fit.match.T_map_scan, fit.match.information);
  const Pose T_odom_base = estimator_->basePose(), T_step = T_previous_.inverse() * T_odom_base;
  watchImu(scan, T_step);
  const double dt = secondsBetween(stamp_, scan.stamp);
  if (dt > 1e-4 && dt < 2.0 && !fit.jumped) twist_ = local(Pose::Identity(), T_step) / dt;
  speed_known_ = true;
  T_fitted_ = T_odom_base;

  out.T_odom_base = T_odom_base;
  out.covariance = reportedCovariance();
  out.quality.inlier_ratio = fit.match.inlierRatio();
  out.quality.rmse_m = fit.match.rmse();
  out.quality.iterations = fit.match.iterations;
  out.quality.degenerate_axes = fit.match.degenerate_axes;
  if (fit.searched && note_.empty()) note_ = fit.jumped ? "looked for after a gap" : "recovered by search";
  out.quality.note = note_;
  stamp_ = scan.stamp;
  T_recorded_ = scan.T_odom_base;
  T_previous_ = T_odom_base;
}

void ImuOdometry::lose(const Scan& scan, const std::string& why, OdometryStep& out) {
  out.T_odom_base = estimator_->basePose();
  if (map_.started()) {
    out.covariance = reportedCovariance();
    stamp_ = scan.stamp;
    T_recorded_ = scan.T_odom_base;
    T_previous_ = out.T_odom_base;
    ++lost_;
  }
  out.quality.ok = false;
  out.quality.inlier_ratio = 0;
  out.quality.degenerate_axes = scan.planar ? 3 : 6;
  out.quality.note = note_.empty() ? why : why + "; " + note_;
}

}  // namespace scslam
