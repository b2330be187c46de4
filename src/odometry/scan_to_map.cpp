#include "scslam/odometry/scan_to_map.h"

#include <algorithm>
#include <cmath>

#include "scslam/core/deskew.h"
#include "scslam/core/voxel_filter.h"
#include "scslam/odometry/usable_points.h"

namespace scslam {
namespace {

constexpr std::size_t kThinAbove = 4000;  // smaller scans are used whole
constexpr int kMisfitsBeforeRestart = 5;
constexpr double kUsualSweepS = 0.1;  // of a scan whose points have no times
constexpr double kAdriftAfterS = 2;   // so long without a scan: the prediction has no claim any more

// Shares of the usual inlier ratio. A scan that looks into new country has few points on the map and yet fits: a poor
// share is a reason to search, only a very poor one to give up, and a far place must fit nearly as well as usual.
constexpr double kPoorShare = 0.7, kLostShare = 0.4, kFarShare = 0.75;
constexpr double kNearBetter = 1.15, kFarBetter = 1.3;     // than the fit at the guess
constexpr double kGuessBetter = 1.1, kThanRecorded = 1.6;  // than the guess before it, than recorded odometry
constexpr double kFarPrecision = 0.75;                     // inliers among the matched points of a far place

/// Is a step of this duration worth a velocity?
bool tellsSpeed(double duration_s) { return duration_s > 1e-4 && duration_s <= 2.0; }

}  // namespace

OdometryStep ScanToMap::step(const Scan& scan) {
  OdometryStep out;
  Prepared prepared;
  const std::string useless = prepare(scan, prepared);
  if (!useless.empty())
    lose(scan, T_odom_base_ * predictedStep(scan.stamp), useless, out);
  else if (!map_)
    start(scan, prepared, out);
  else
    follow(scan, prepared, out);
  out.cloud = std::move(prepared.cloud);
  return out;
}

void ScanToMap::start(const Scan& scan, Prepared& prepared, OdometryStep& out) {
  clearMap();
  stamp_ = scan.stamp;
  T_recorded_ = scan.T_odom_base;
  insert(prepared.features, T_odom_base_);
  if (compensatesFirst()) first_ = prepared.raw;
  out.T_odom_base = T_odom_base_;
}

void ScanToMap::follow(const Scan& scan, Prepared& prepared, OdometryStep& out) {
  const Guess guess = bestGuess(scan, prepared.raw[0]);
  Fit fit = fitScan(prepared, scan, guess);
  const bool jumped =
      doubtful(fit.match, guess, scan.stamp) && searched(prepared.features, guess, scan.stamp, fit.match, out.quality);
  if (!first_.empty() && share(fit.match) >= kLostShare) beginAgain(prepared, scan, fit);
  if (fit.deskewed) compensate(prepared.cloud, fit.twist);
  // After a gap nothing but the fit itself speaks for a place.
  if (share(fit.match) < (adrift(guess, scan.stamp) ? kFarShare : kLostShare)) {
    const std::string why = fmt::format("the scan does not fit the map (inliers {:.2f}, usually {:.2f})",
                                        fit.match.clearRatio(), usual_inliers_);
    // What fits nowhere cannot tell a stop from going on.
    lose(scan, guess.recorded() ? guess.T_odom_base : T_odom_base_ * predictedStep(scan.stamp), why, out);
    if (++misfits_ == kMisfitsBeforeRestart) restartMap(prepared, out.quality);
  } else {
    accept(scan, fit.match, jumped, out);
    twist_ = fit.deskewed && !jumped ? std::optional(fit.twist) : std::nullopt;
    out.passing = unsteadiness(prepared.cloud.hasTime() ? sweepDuration(prepared.raw[0]) : kUsualSweepS);
    insert(prepared.features, T_odom_base_);
    forgetBeyond(T_odom_base_.translation(), 1.25 * params_.max_range_m);
  }
}

void ScanToMap::compensate(Cloud& cloud, const Vector6d& twist) const { deskew(cloud, twist); }

void ScanToMap::insert(const Features& features, const Pose& T_odom_base) { map_->insert(features[0], T_odom_base); }

void ScanToMap::forgetBeyond(const Eigen::Vector3d& centre, double radius_m) {
  map_->forgetBeyond(centre, radius_m, map_->level(0).size() / 16 + 64);
}

// ---- the scan ----

std::string ScanToMap::prepare(const Scan& scan, Prepared& prepared) {
  prepared.cloud = usablePoints(scan, params_.min_range_m, params_.max_range_m);
  if (prepared.cloud.size() < leastPoints(scan.planar))
    return fmt::format("only {} usable points", prepared.cloud.size());
  if (!map_) {
    planar_ = scan.planar;
    voxel_m_ = params_.voxel_m > 0 ? params_.voxel_m : voxelFor(prepared.cloud, planar_);
  }
  const std::string useless = extract(prepared.cloud, scan, prepared.raw);
  prepared.features = prepared.raw;
  return useless;
}

Cloud ScanToMap::thin(const Cloud& cloud, double voxel_m) {
  if (cloud.size() <= kThinAbove) return cloud;
  const std::vector<std::uint32_t> kept = onePerVoxel(cloud, voxel_m);
  Cloud thinned = selected(cloud, kept);
  if (!cloud.hasTime()) return thinned;
  thinned.dt.reserve(kept.size());
  for (const std::uint32_t i : kept) thinned.dt.push_back(cloud.dt[i]);
  return thinned;
}

// ---- the guess ----

Pose ScanToMap::predictedStep(Stamp stamp) const {
  if (!moving_known_) return Pose::Identity();
  const double now_s = secondsBetween(stamp_, stamp);
  if (step_s_ <= 0 || now_s <= 0) return T_step_;
  const double ratio = std::min(now_s / step_s_, kFollowedSteps);
  return retract(Pose::Identity(), ratio * local(Pose::Identity(), T_step_));
}

ScanToMap::Guess ScanToMap::bestGuess(const Scan& scan, const Cloud& source) const {
  std::vector<Guess> guesses = {{T_odom_base_ * predictedStep(scan.stamp), Matrix6d::Zero()}};
  if (params_.use_recorded_odometry && T_recorded_ && scan.T_odom_base) {
    const Pose T_step = T_recorded_->inverse() * *scan.T_odom_base;
    if (isRigid(T_step)) guesses.insert(guesses.begin(), {T_odom_base_ * T_step, recordedInformation(T_step)});
  }
  // Has it stopped? Between slow sweeps no robot does so suddenly, and some walls look alike from two places.
  if (moving_known_ && !slowSweeps()) guesses.push_back({T_odom_base_, Matrix6d::Zero()});
  const Cloud few = thinned(source, 500);
  // A later guess must be clearly better: scores of near guesses differ by noise.
  std::size_t best = 0;
  double best_score = 0;
  for (std::size_t i = 0; i < guesses.size(); ++i) {
    const double score = matchScore(*map_, 1, few, guesses[i].T_odom_base, voxel_m_);
    const bool against_recorded = guesses[best].recorded();
    if (i == 0 || score > (against_recorded ? kThanRecorded : kGuessBetter) * best_score) {
      best = i;
      best_score = score;
    }
  }
  return guesses[best];
}

Matrix6d ScanToMap::recordedInformation(const Pose& T_step) const {
  // Wheels slip, in turns most of all: a tenth of the way, a third of the turn, and a floor.
  const double sigma_m = 0.2 * voxel_m_ + 0.1 * T_step.translation().norm();
  const double sigma_rad = 0.03 + 0.2 * rotationAngle(T_step);
  Vector6d information;
  information << Eigen::Vector3d::Constant(1 / (sigma_m * sigma_m)),
      Eigen::Vector3d::Constant(1 / (sigma_rad * sigma_rad));
  return information.asDiagonal();
}

// ---- the fit ----

MatchOptions ScanToMap::matchOptions(const Guess& guess) const {
  MatchOptions options;
  options.levels = {0, kLevels - 1};
  options.max_iterations = params_.max_iterations;
  options.inlier_m = (planar_ ? 0.5 : 0.3) * voxel_m_;
  options.sigma_m = planar_ ? std::max(0.06 * voxel_m_, 0.02) : 0.06 * voxel_m_;
  options.planar = planar_;
  options.guess_information = guess.information;
  options.T_map_scan_believed = guess.T_odom_base;
  return options;
}

MatchResult ScanToMap::matchFromGuess(const Features& features, const Guess& guess) const {
  return match(features, guess, closer(features, guess));
}

Vector6d ScanToMap::twistOf(const Pose& T_previous_base, Stamp stamp) const {
  const double duration_s = secondsBetween(stamp_, stamp);
  if (!tellsSpeed(duration_s)) return Vector6d::Zero();
  return local(Pose::Identity(), T_previous_base) / duration_s;
}

bool ScanToMap::moreThanNoise(const Vector6d& twist, double sweep_s) const {
  return sweep_s * twist.head<3>().norm() > 0.04 * voxel_m_ || sweep_s * twist.tail<3>().norm() > 2e-3;
}

ScanToMap::Fit ScanToMap::fitDeskewed(Prepared& prepared, const Scan& scan, const Guess& guess) const {
  const double sweep_s = sweepDuration(prepared.raw[0]), since_s = secondsBetween(stamp_, scan.stamp);
  // What a fit tells is where the robot was in the middle of the sweep; the pose at the stamp follows with the velocity
  // that was assumed, `mid` steps before. So a velocity measured between stamps depends on the one assumed, and swings
  // from scan to scan. Between the middles of two compensated sweeps it does not: that is taken; with the sweep before
  // not compensated, the velocity that confirms itself.
  const double mid = tellsSpeed(since_s) ? meanTime(prepared.raw[0]) / since_s : 0;
  Fit fit;
  fit.deskewed = true;
  Guess from = guess;
  // The guessed velocity first; once more with the measured one when they differ (turns, starts, stops).
  for (int round = 0; round < 2; ++round) {
    Vector6d change = twistOf(T_odom_base_.inverse() * from.T_odom_base, scan.stamp) - fit.twist;
    if (round > 0) change = twist_ ? Vector6d(change + mid * (fit.twist - *twist_)) : change / std::max(1 + mid, 0.25);
    if (round > 0 && !moreThanNoise(change, sweep_s)) break;
    fit.twist += change;
    prepared.features = prepared.raw;
    for (Cloud& part : prepared.features) compensate(part, fit.twist);
    fit.match = matchFromGuess(prepared.features, from);
    from.T_odom_base = fit.match.T_map_scan;
  }
  return fit;
}

void ScanToMap::beginAgain(Prepared& prepared, const Scan& scan, Fit& fit) {
  constexpr int kMostRounds = 20;
  constexpr double kFine = 10;  // both sweeps are wrong in the same way, which shows little: settle it well
  const double sweep_s = sweepDuration(prepared.raw[0]);
  for (int round = 0; round < kMostRounds && canDeskew(prepared, scan); ++round) {
    const Vector6d before = fit.twist, twist = twistOf(T_odom_base_.inverse() * fit.match.T_map_scan, scan.stamp);
    if (!moreThanNoise(round == 0 ? twist : kFine * (twist - before), sweep_s)) break;
    Features first = first_;
    for (Cloud& part : first) compensate(part, twist);
    clearMap();
    insert(first, T_fitted_);
    fit = fitDeskewed(prepared, scan, {fit.match.T_map_scan, Matrix6d::Zero()});
  }
  first_.clear();
}

bool ScanToMap::canDeskew(const Prepared& prepared, const Scan& scan) const {
  return params_.deskew != "off" && prepared.cloud.hasTime() && !scan.deskewed;
}

ScanToMap::Fit ScanToMap::fitScan(Prepared& prepared, const Scan& scan, const Guess& guess) {
  const Vector6d twist = twistOf(T_odom_base_.inverse() * guess.T_odom_base, scan.stamp);
  if (!canDeskew(prepared, scan) ||
      (params_.deskew == "auto" && !moreThanNoise(twist, sweepDuration(prepared.raw[0])))) {
    return {matchFromGuess(prepared.raw, guess), Vector6d::Zero(), false};
  }
  if (params_.deskew == "on") return fitDeskewed(prepared, scan, guess);

  // auto: constant velocity over a sweep is a claim (and somebody may have compensated the cloud before us), so it is
  // tested against the map, often at first, then now and then.
  constexpr int kTrialsAtFirst = 10, kTrialEvery = 10;
  const bool trial = deskew_trials_ < kTrialsAtFirst || deskew_trials_ % kTrialEvery == 0;
  ++deskew_trials_;
  if (!trial && deskew_evidence_ < 0) return {matchFromGuess(prepared.raw, guess), Vector6d::Zero(), false};
  if (!trial) return fitDeskewed(prepared, scan, guess);
  const Fit plain{matchFromGuess(prepared.raw, guess), Vector6d::Zero(), false};
  const Fit compensated = fitDeskewed(prepared, scan, guess);
  deskew_evidence_ = 0.9 * deskew_evidence_ + (compensated.match.meanScore() - plain.match.meanScore());
  if (deskew_evidence_ >= 0) return compensated;
  prepared.features = prepared.raw;
  return plain;
}

double ScanToMap::share(const MatchResult& match) const {
  if (match.system.inliers < leastPoints(planar_) / 2 || match.inlierRatio() < leastInliers()) return 0.0;
  return usual_inliers_ > 0 ? match.clearRatio() / usual_inliers_ : 1.0;
}

bool ScanToMap::adrift(const Guess& guess, Stamp stamp) const {
  const double gap_s = secondsBetween(stamp_, stamp);
  return !guess.recorded() && (lost_ >= kAdriftAfter || std::abs(gap_s) > std::max(kAdriftAfterS, 5 * step_s_));
}

bool ScanToMap::doubtful(const MatchResult& match, const Guess& guess, Stamp stamp) const {
  const Vector6d d = local(T_odom_base_ * predictedStep(stamp), match.T_map_scan);
  const bool surprising = d.head<3>().norm() > 2.0 * voxel_m_ || d.tail<3>().norm() > 0.2;
  return !moving_known_ || adrift(guess, stamp) || (surprising && !guess.recorded()) || share(match) < kPoorShare;
}

bool ScanToMap::outweighs(const MatchResult& found, const MatchResult& match, const Guess& guess) const {
  const auto strain = [&guess](const MatchResult& m) {
    const Vector6d d = local(guess.T_odom_base, m.T_map_scan);
    return 0.5 * d.dot(guess.information * d);
  };
  // An inlier is worth up to half of (3 sigma)^2 in likelihood, shared by the points that count as one.
  const double gain =
      (found.meanScore() - match.meanScore()) * match.system.points * 4.5 / MatchResult::kCorrelatedPoints;
  return gain > strain(found) - strain(match);
}

bool ScanToMap::searched(const Features& features, const Guess& guess, Stamp stamp, MatchResult& match,
                         OdometryQuality& quality) const {
  const MatchResult near = search(features, guess.T_odom_base, guess.recorded() ? Reach::kStep : Reach::kNear);
  if (near.meanScore() > kNearBetter * match.meanScore() && outweighs(near, match, guess)) match = near;
  const auto precise = [](const MatchResult& m) {
    return m.system.clear_inliers >= kFarPrecision * m.system.clear_matched;
  };
  if (adrift(guess, stamp)) {
    // It may have gone on or stopped: the best fit about both places counts, not the first that is good enough.
    for (const Pose& T_odom_base : {guess.T_odom_base, T_fitted_}) {
      const MatchResult far = search(features, T_odom_base, Reach::kFar);
      if (precise(far) && far.meanScore() > match.meanScore()) match = far;
    }
    quality.note = "looked for after a gap";
    return true;
  }
  // A planar scan sees half the room, and recorded odometry would know of a turn: there only a lost scan looks far
  // away.
  if (share(match) >= (planar_ || guess.recorded() ? kLostShare : kPoorShare)) return false;
  const MatchResult far = search(features, guess.T_odom_base, Reach::kFar);
  if (!precise(far) || share(far) < kFarShare || far.clearRatio() < kFarBetter * match.clearRatio()) return false;
  match = far;
  quality.note = "recovered by rotation search";
  return true;
}

void ScanToMap::restartMap(const Prepared& prepared, OdometryQuality& quality) {
  clearMap();
  insert(prepared.features, T_odom_base_);
  if (compensatesFirst()) first_ = prepared.raw;
  T_fitted_ = T_odom_base_;
  usual_inliers_ = 0;
  miss_.setZero();
  misses_ = 0;
  lost_ = misfits_ = 0;
  quality.note += "; local map restarted";
}

MatchResult ScanToMap::search(const Features& features, const Pose& T_odom_base_guess, Reach reach) const {
  const double coarse_m = voxel_m_ * (1 << (kLevels - 1));
  PoseGrid grid;
  grid.yaw_range_rad = reach == Reach::kFar ? M_PI : 0.3;
  grid.yaw_step_rad = 0.07;
  grid.xy_range_m = reach == Reach::kStep ? coarse_m : 3.0 * coarse_m;
  grid.xy_step_m = 0.5 * coarse_m;
  const Cloud source = thin(features[0], voxel_m_);
  const Guess anywhere{T_odom_base_guess, Matrix6d::Zero()};
  const MatchResult found =
      searchAndMatch(*map_, source, T_odom_base_guess, grid, matchOptions(anywhere), context_.threads);
  return match(features, {found.T_map_scan, Matrix6d::Zero()}, found.T_map_scan);
}

}  // namespace scslam
