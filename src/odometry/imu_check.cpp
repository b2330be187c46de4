#include "scslam/odometry/imu_check.h"

#include <fmt/format.h>

#include <cmath>

namespace scslam {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kEnoughSamples = 5;
constexpr double kDegree = M_PI / 180;

std::string axesOf(const Vector3d& v) { return fmt::format("({:.2f}, {:.2f}, {:.2f})", v.x(), v.y(), v.z()); }

/// Sets accel_scale and usable from the length of the mean force.
void judgeLength(double mean_force, double gravity_m_s2, ImuStart& start) {
  constexpr double kMost = 1.6, kLeast = 0.5;  // of gravity: what braking and bumps leave of it
  if (mean_force > kLeast * gravity_m_s2 && mean_force < kMost * gravity_m_s2) {
    start.usable = true;
  } else if (mean_force > kLeast && mean_force < kMost) {
    start.usable = true;
    start.accel_scale = gravity_m_s2;
    start.note = fmt::format("the IMU's accelerations are in g (mean length {:.2f}), taken times {:.2f} as m/s^2",
                             mean_force, gravity_m_s2);
  } else {
    start.note = fmt::format(
        "the IMU's mean acceleration is {:.2f}: neither gravity in m/s^2 nor in g (does its driver remove gravity?); "
        "going on without IMU",
        mean_force);
  }
}

}  // namespace

ImuStart startOf(const std::deque<ImuSample>& samples, const Pose& T_base_imu, double gravity_m_s2,
                 double max_tilt_deg) {
  ImuStart start;
  start.enough = samples.size() >= kEnoughSamples;
  if (!start.enough) return start;
  const auto n = static_cast<double>(samples.size());
  Vector3d force = Vector3d::Zero(), rate2 = Vector3d::Zero();
  for (const ImuSample& s : samples) force += s.accel_m_s2 / n, start.gyro += s.gyro_rad_s / n;
  double force_spread2 = 0;
  for (const ImuSample& s : samples) {
    rate2 += (s.gyro_rad_s - start.gyro).cwiseAbs2() / n;
    force_spread2 += (s.accel_m_s2 - force).squaredNorm() / n;
  }
  judgeLength(force.norm(), gravity_m_s2, start);
  start.accel = start.accel_scale * force;
  if (!start.usable) return start;

  const Vector3d up_base = T_base_imu.linear() * force.normalized();
  const double tilt = std::acos(std::min(1.0, std::max(-1.0, up_base.z())));
  if (tilt > max_tilt_deg * kDegree) {
    start.usable = false;
    start.note = fmt::format(
        "by the IMU's gravity, up is {} of the base frame, {:.0f} degrees from its z axis: swapped axes, or a wrong "
        "sensorPose (T_base_imu) in the recording; going on without IMU",
        axesOf(up_base), tilt / kDegree);
    return start;
  }
  start.still = start.gyro.norm() < 0.05 && std::sqrt(rate2.sum()) < 0.02 &&
                std::abs(start.accel.norm() - gravity_m_s2) < 0.3 && start.accel_scale * std::sqrt(force_spread2) < 0.3;
  return start;
}

void ImuCheck::add(const Vector3d& by_gyro, const Vector3d& by_scan, const Vector3d& rate_begin,
                   const Vector3d& rate_end) {
  const Vector3d e = by_scan - by_gyro, dw = rate_end - rate_begin;
  ++steps_;
  e_dw_ += e.dot(dw);
  dw2_ += dw.squaredNorm();
  e2_ += e.squaredNorm();
  if (by_gyro.norm() < 0.01 && by_scan.norm() < 0.01) return;  // noise
  ++turns_;
  gyro2_ += by_gyro.squaredNorm();
  scan2_ += by_scan.squaredNorm();
  gyro_scan_ += by_gyro.dot(by_scan);
}

ImuCheck::Offset ImuCheck::offset() const {
  if (steps_ < 10 || dw2_ < 1e-9) return {};
  const double tau = -e_dw_ / dw2_;
  const double left2 = std::max(e2_ + tau * e_dw_, 0.0) / (3 * steps_ - 1);
  return {tau, std::sqrt(left2 / dw2_)};
}

void ImuCheck::restartOffset() { steps_ = e_dw_ = dw2_ = e2_ = 0; }

std::string ImuCheck::disagreement() const {
  constexpr double kEnoughTurn2 = 0.1, kEnoughTurns = 10;  // [rad^2]
  if (turns_ < kEnoughTurns || std::max(gyro2_, scan2_) < kEnoughTurn2) return "";
  const double share = gyro_scan_ / std::max(gyro2_, 1e-12), alike = gyro_scan_ / std::sqrt(gyro2_ * scan2_ + 1e-12);
  if (alike > 0.7 && share > 0.7 && share < 1.4) return "";
  if (alike > 0.7 && std::abs(share / kDegree - 1) < 0.3) return "the IMU's rates are in degrees per second, not rad/s";
  if (alike < -0.7) return "the IMU turns against the scans: its axes are mirrored or swapped";
  return fmt::format(
      "the IMU's turns are not those of the scans ({:.2f} of them, correlation {:.2f}): wrong units, "
      "swapped axes or another clock",
      share, alike);
}

void ImuCheck::save(ByteWriter& state) const {
  for (const double value : {steps_, e_dw_, dw2_, e2_, gyro2_, scan2_, gyro_scan_, turns_}) state.put(value);
}

void ImuCheck::load(ByteReader& state) {
  for (double* value : {&steps_, &e_dw_, &dw2_, &e2_, &gyro2_, &scan2_, &gyro_scan_, &turns_}) state.get(*value);
}

}  // namespace scslam
