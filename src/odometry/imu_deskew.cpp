#include "scslam/odometry/imu_deskew.h"

#include <algorithm>
#include <cmath>

namespace scslam {
namespace {

// Between two poses points follow the chord; at 5 rad/s and 0.1 s its error is 8e-6 of the range.
constexpr std::size_t kSlices = 64;

/// A rotation and translation, float, by rows.
struct Row34 {
  float m[12];
};

Row34 rowsOf(const Pose& T) {
  Row34 rows;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) rows.m[4 * r + c] = static_cast<float>(T.matrix()(r, c));
  return rows;
}

}  // namespace

SweepMotion sweepMotion(const std::vector<ImuReading>& readings, const NavState& state, const ImuBias& bias,
                        const Eigen::Vector3d& gravity, const Pose& T_base_imu) {
  SweepMotion sweep;
  if (readings.size() < 2) return sweep;
  sweep.slice_s = readings.back().t / kSlices;
  sweep.poses.reserve(kSlices + 1);
  const Pose T_imu_base = T_base_imu.inverse();
  const Eigen::Matrix3d R_imu_odom = state.R.transpose();
  ImuMotion motion;
  ImuReading last = readings.front();
  std::size_t next = 1;  // first reading after `last`
  for (std::size_t k = 0; k <= kSlices; ++k) {
    const double t = sweep.slice_s * static_cast<double>(k);
    while (next + 1 < readings.size() && readings[next].t <= t) {
      motion = motion.then(motionBetween(last, readings[next], bias));
      last = readings[next++];
    }
    if (t > last.t) {
      const double u = std::min((t - last.t) / (readings[next].t - last.t), 1.0);
      const ImuReading now{t, last.gyro + u * (readings[next].gyro - last.gyro),
                           last.accel + u * (readings[next].accel - last.accel)};
      motion = motion.then(motionBetween(last, now, bias));
      last = now;
    }
    const NavState then = state.after(motion, gravity);
    Pose T_stamp_now = Pose::Identity();
    T_stamp_now.linear() = motion.dR;
    T_stamp_now.translation() = R_imu_odom * (then.p - state.p);
    sweep.poses.push_back(T_base_imu * T_stamp_now * T_imu_base);
  }
  return sweep;
}

SweepMotion sweepMotion(const Vector6d& twist, double sweep_s) {
  SweepMotion sweep;
  if (sweep_s <= 0 || twist.isZero(0.0)) return sweep;
  sweep.slice_s = sweep_s / kSlices;
  for (std::size_t k = 0; k <= kSlices; ++k) {
    const double t = sweep.slice_s * static_cast<double>(k);
    Pose T = Pose::Identity();
    T.linear() = so3Exp(t * twist.tail<3>());
    T.translation() = t * twist.head<3>();
    sweep.poses.push_back(T);
  }
  return sweep;
}

void deskew(Cloud& cloud, const SweepMotion& motion) {
  if (!cloud.hasTime() || motion.poses.size() < 2) return;
  std::vector<Row34> poses;
  for (const Pose& T : motion.poses) poses.push_back(rowsOf(T));
  poses.push_back(poses.back());
  const auto per_slice = static_cast<float>(1 / motion.slice_s), end = static_cast<float>(motion.poses.size() - 1);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float at = cloud.dt[i] * per_slice;
    const float position = at > 0 ? std::min(at, end) : 0.0f;  // a NaN counts as the stamp
    const auto k = static_cast<std::size_t>(position);
    const float u = position - static_cast<float>(k);
    const float *a = poses[k].m, *b = poses[k + 1].m;
    float m[12];
    for (int j = 0; j < 12; ++j) m[j] = a[j] + u * (b[j] - a[j]);
    const float x = cloud.x[i], y = cloud.y[i], z = cloud.z[i];
    cloud.x[i] = m[0] * x + m[1] * y + m[2] * z + m[3];
    cloud.y[i] = m[4] * x + m[5] * y + m[6] * z + m[7];
    cloud.z[i] = m[8] * x + m[9] * y + m[10] * z + m[11];
  }
}

}  // namespace scslam
