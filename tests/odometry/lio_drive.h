// A robot with a spinning LiDAR and an IMU, driven hard: every point has its time, every reading its lever arm.
#pragma once
#include <functional>
#include <vector>

#include "scslam/odometry/odometry.h"
#include "sim/imu.h"
#include "support/support.h"

namespace scslam::test {

/// Points of a world by number, in its frame.
using World = std::function<Cloud(std::uint32_t seed)>;

struct InertialDrive {
  sim::Trajectory trajectory;
  Pose T_base_imu;
  World world;
  double period_s = 0.1;

  Pose pose(double t) const { return trajectory.pose(t); }
  static Stamp stamp(double t) { return stampFromNanoseconds(1'600'000'000'000'000'000 + std::llround(t * 1e9)); }
  double start(std::size_t k) const { return period_s * static_cast<double>(k); }

  /// Sweep number k, with the IMU readings (200 Hz) up to the next one.
  Scan scan(std::size_t k) const {
    Scan scan;
    scan.index = k;
    scan.stamp = stamp(start(k));
    scan.T_base_sensor = poseFromYaw(0.4, {0.3, 0.1, 1.2});
    const Cloud points = world(static_cast<std::uint32_t>(k) + 10);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double dt = period_s * static_cast<double>(i) / static_cast<double>(points.size());
      const Pose T_sensor_world = (pose(start(k) + dt) * scan.T_base_sensor).inverse();
      const Eigen::Vector3f p = (T_sensor_world * points.point(i).cast<double>()).cast<float>();
      scan.cloud.push(p.x(), p.y(), p.z());
      scan.cloud.dt.push_back(static_cast<float>(dt));
    }
    scan.T_base_imu = T_base_imu;
    const int first = k == 0 ? 0 : static_cast<int>(std::lround(200 * start(k))) + 1;
    for (int i = first; i <= std::lround(200 * start(k + 1)); ++i) scan.imu.push_back(reading(i / 200.0));
    return scan;
  }

  ImuSample reading(double t) const {
    const sim::ImuReading ideal = sim::idealImu(trajectory.state(t), T_base_imu, 9.81);
    ImuSample sample{stamp(t), ideal.angular_velocity, ideal.specific_force};
    sample.gyro_rad_s += Eigen::Vector3d(0.002, -0.003, 0.004);  // biases
    sample.accel_m_s2 += Eigen::Vector3d(0.03, -0.02, 0.04);
    return sample;
  }
};

inline Pose tiltedImu() {
  Pose T = poseFromYaw(1.1, {0.3, -0.1, 0.4});
  T.linear() = T.linear() * so3Exp({0.2, -0.3, 0});
  return T;
}

/// Points in an order that a spinning sensor could see: all around, again and again, not surface by surface.
inline Cloud shuffled(const Cloud& cloud) {
  Cloud result;
  const std::size_t n = cloud.size();
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t k = i * 7919 % n;  // a prime that does not divide n
    result.push(cloud.x[k], cloud.y[k], cloud.z[k]);
  }
  return result;
}

/// In the room of support.h: half a second still, then curves at up to 5 m/s and 2 rad/s with braking and pitching.
inline InertialDrive wildDrive(double still_s = 0.5) {
  std::vector<Pose> control;
  for (int i = -1; i < 130; ++i) {
    const double t = std::max(0.0, 0.1 * i - still_s), u = t * t / (t + 1);  // sets off smoothly
    Pose T = poseFromYaw(0.8 * u, {4 * std::sin(0.8 * u), 2.5 * std::sin(1.1 * u), 0.3 * std::sin(u)});
    T.linear() = T.linear() * so3Exp({0.1 * std::sin(2 * u), 0.15 * std::sin(1.5 * u), 0});
    control.push_back(T);
  }
  return {{control, 0.1}, tiltedImu(), [](std::uint32_t seed) { return shuffled(aRoom(6007, seed, 0.01)); }};
}

}  // namespace scslam::test
