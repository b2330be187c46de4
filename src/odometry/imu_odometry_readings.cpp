// The inertial half: start, prediction, what is watched and said.
#include <algorithm>
#include <cmath>
#include <limits>

#include "scslam/core/log.h"
#include "scslam/odometry/imu_odometry.h"

namespace scslam {

using Eigen::Vector3d;

void ImuOdometry::say(Said what, const std::string& line) {
  if (said_ & what) return;
  said_ |= what;
  logWarn(context_.log, "{}: {}", name_, line);
  note_ += note_.empty() ? line : "; " + line;
}

void ImuOdometry::takeReadings(const Scan& scan) {
  stream_.add(scan.imu);
  if (inertial_ || refused_) return;
  if (scan.planar) {
    if (!stream_.empty()) say(kPlanar, "a 2-D scanner moves in its plane: the IMU is not used");
    refused_ = true;
    return;
  }
  const ImuStart start = startOf(stream_.samples(), scan.T_base_imu, params_.gravity_m_s2, params_.max_tilt_deg);
  if (!start.enough) {
    say(kNoImu, "no IMU readings come with the scans: going on with the LiDAR alone, at constant speed in between");
    return;
  }
  if (!start.note.empty()) say(kStart, start.note);
  refused_ = !start.usable;
  if (start.usable) beginInertial(scan, start);
}

void ImuOdometry::beginInertial(const Scan& scan, const ImuStart& start) {
  inertial_ = true;
  stream_.accel_scale = start.accel_scale;
  // The first scan may define odom, so it is made level; later, odom is what it is and gravity is found in it.
  Pose T_odom_base = estimator_->basePose();
  if (!map_.started()) {
    const Vector3d up_base = (scan.T_base_imu.linear() * start.accel).normalized();
    Pose level = Pose::Identity();
    level.linear() = Eigen::Quaterniond::FromTwoVectors(up_base, Vector3d::UnitZ()).toRotationMatrix();
    T_odom_base = poseFromYaw(-yawOf(level), Vector3d::Zero()) * level;
  }
  const Vector3d up_odom = ((T_odom_base * scan.T_base_imu).linear() * start.accel).normalized();
  const Vector3d v_odom = speed_known_ ? Vector3d(T_odom_base.linear() * twist_.head<3>()) : Vector3d::Zero();
  ImuEstimator::Start sigma;
  if (start.still) sigma.velocity_mps = 0.1;
  if (speed_known_) sigma.velocity_mps = 1;
  if (params_.estimate_mounting) sigma.mounting_m = 0.05, sigma.mounting_rad = 0.03;
  estimator_->begin(T_odom_base, scan.T_base_imu, -params_.gravity_m_s2 * up_odom, v_odom, sigma);
  // Force is gravity, and a rate is bias, only at rest; otherwise force is gravity but for what the robot does.
  const double accel_sigma = start.still ? 0.01 : 3.0;
  const double gyro_sigma = start.still ? 2e-3 : std::numeric_limits<double>::infinity();
  estimator_->measureRest(start.accel, accel_sigma, start.gyro, gyro_sigma);
}

void ImuOdometry::stopInertial() {
  inertial_ = false, refused_ = true;
  const Pose T_odom_base = estimator_->basePose();
  estimator_->begin(T_odom_base, Pose::Identity(), {0, 0, -params_.gravity_m_s2}, Vector3d::Zero(), {});
}

void ImuOdometry::predict(const Scan& scan) {
  estimator_->beginStep();
  const std::vector<ImuReading> readings = inertial_ ? stream_.between(stamp_, scan.stamp) : std::vector<ImuReading>();
  by_imu_ = !readings.empty();
  if (by_imu_) {
    const ImuPreintegration imu(readings, estimator_->bias(), params_.noise);
    const Eigen::Matrix3d R_base_imu = estimator_->mounting().linear();
    gyro_turn_ = R_base_imu * so3Log(imu.motion().dR);
    rate_begin_ = R_base_imu * readings.front().gyro;
    rate_end_ = R_base_imu * readings.back().gyro;
    estimator_->predict(imu, params_.noise);
  } else {
    // Beyond a second nobody knows what the speed was.
    constexpr double kLongest = 1.0;
    const double dt = std::max(secondsBetween(stamp_, scan.stamp), 0.0);
    estimator_->predictAtSpeed(
        speed_known_ ? (std::min(1.0, kLongest / std::max(dt, 1e-9)) * twist_).eval() : Vector6d::Zero().eval(), dt);
    if (inertial_ && dt > 0) note_ += fmt::format("{}no IMU for this step", note_.empty() ? "" : "; ");
  }
  stream_.forgetBefore(scan.stamp - (stampFromSeconds(0.2) - stampFromSeconds(0)));
}

SweepMotion ImuOdometry::sweepOf(const Scan& scan, double sweep_s, const ImuEstimator& estimator) const {
  if (!params_.deskew || scan.deskewed || sweep_s <= 0) return {};
  if (inertial_) {
    const Stamp end = scan.stamp + (stampFromSeconds(sweep_s) - stampFromSeconds(0));
    const auto readings = stream_.between(scan.stamp, end);
    if (!readings.empty())
      return sweepMotion(readings, estimator.nav(), estimator.bias(), estimator.gravity(), estimator.mounting());
  }
  const Pose T_step = T_previous_.inverse() * estimator.basePose();
  const double dt = secondsBetween(stamp_, scan.stamp);
  if (dt <= 1e-4 || dt > 2.0) return {};
  return sweepMotion(local(Pose::Identity(), T_step) / dt, sweep_s);
}

void ImuOdometry::watchImu(const Scan&, const Pose& T_previous_base) {
  if (!inertial_ || !by_imu_) return;
  check_.add(gyro_turn_, so3Log(T_previous_base.linear()), rate_begin_, rate_end_);
  if (const std::string line = check_.disagreement(); !line.empty()) {
    say(kDisagrees, line + "; going on without IMU");
    stopInertial();
    return;
  }
  const ImuCheck::Offset offset = check_.offset();
  constexpr double kWorthIt = 0.003, kSure = 5.0, kKnown = 0.004;  // [s], sigmas, [s]
  if (offset.sigma_s > kKnown || std::abs(offset.seconds) < std::max(kWorthIt, kSure * offset.sigma_s)) return;
  const double total = stream_.time_offset_s + offset.seconds;
  const std::string line = fmt::format(
      "the IMU's clock is {:.0f} ms {} that of the scans (imu_time_offset_s: {:.3f}){}", 1000 * std::abs(total),
      total > 0 ? "behind" : "ahead of", total, params_.estimate_time_offset ? "; taken into account" : "");
  say(kClock, line);
  if (params_.estimate_time_offset) stream_.time_offset_s = total;
  check_.restartOffset();
}

}  // namespace scslam
