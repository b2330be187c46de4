// Drives and small helpers that the tests of the navigation sensors share.
#pragma once
#include <mrpt/obs/CObservation.h>

#include <cmath>
#include <memory>
#include <vector>

#include "sim/navigation_sensor.h"
#include "sim/trajectory.h"

namespace scslam::sim::test {

/// 2024-05-06 10:20:30 UTC.
inline Stamp start() { return stampFromSeconds(1714990830); }

/// Stays at a pose.
inline Trajectory parked(double duration_s, const Pose& T = Pose::Identity()) {
  return Trajectory(std::vector<Pose>(4, T), duration_s);
}

/// Along x, from the origin, at a constant speed (negative: in reverse).
inline Trajectory straight(double speed_mps, double duration_s) {
  std::vector<Pose> control;
  for (int i = 0; i < 4; ++i) control.push_back(poseFromYaw(0, {speed_mps * duration_s * (i - 1), 0, 0}));
  return Trajectory(control, duration_s);
}

/// Counter-clockwise on a circle about (0, radius), starting at the origin along x. Between knots of a degree the
/// spline is off the circle by less than 1e-4 of the radius.
inline Trajectory circle(double radius_m, double speed_mps, double turns) {
  std::vector<Pose> control;
  const double step = M_PI / 180;
  const int n = static_cast<int>(std::lround(turns * 360));
  for (int i = -1; i <= n + 1; ++i)
    control.push_back(poseFromYaw(i * step, {radius_m * std::sin(i * step), radius_m * (1 - std::cos(i * step)), 0}));
  return Trajectory(control, step * radius_m / speed_mps);
}

/// A drive with turns, slopes, speeding up and braking, 30 s.
inline Trajectory lively() {
  std::vector<Pose> control;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  for (int i = 0; i < 63; ++i) {
    const double t = 0.5 * i, yaw = 0.9 * std::sin(0.5 * t);
    Pose T = poseFromYaw(yaw, p);
    T.linear() = T.linear() * Eigen::AngleAxisd(0.15 * std::sin(1.3 * t), Eigen::Vector3d::UnitY()) *
                 Eigen::AngleAxisd(0.1 * std::sin(1.7 * t), Eigen::Vector3d::UnitX());
    control.push_back(T);
    p += 0.5 * (6 + 4 * std::sin(0.4 * t)) * Eigen::Vector3d(std::cos(yaw), std::sin(yaw), 0.08 * std::sin(0.6 * t));
  }
  return Trajectory(control, 0.5);
}

/// Everything a sensor emits up to t [s].
template <class Observation>
std::vector<std::shared_ptr<const Observation>> emitted(NavigationSensor& sensor, double t = 1e9) {
  std::vector<std::shared_ptr<const Observation>> all;
  sensor.upTo(t, [&all](const mrpt::obs::CObservation::Ptr& o) {
    all.push_back(std::dynamic_pointer_cast<const Observation>(o));
  });
  return all;
}

struct Moments {
  double mean = 0, sigma = 0;
};
inline Moments momentsOf(const std::vector<double>& x) {
  Moments m;
  const auto n = static_cast<double>(x.size());
  for (const double v : x) m.mean += v / n;
  for (const double v : x) m.sigma += (v - m.mean) * (v - m.mean) / (n - 1);
  m.sigma = std::sqrt(m.sigma);
  return m;
}
/// The sample mean and sigma lie within 3 of their own standard deviations.
#define EXPECT_MOMENTS(values, mean_expected, sigma_expected)                                       \
  do {                                                                                              \
    const auto moments_ = ::scslam::sim::test::momentsOf(values);                                   \
    const double root_n_ = std::sqrt(static_cast<double>((values).size()));                         \
    EXPECT_NEAR(moments_.mean, mean_expected, 3 * (sigma_expected) / root_n_);                      \
    EXPECT_NEAR(moments_.sigma, sigma_expected, 3 * (sigma_expected) / (std::sqrt(2.0) * root_n_)); \
  } while (false)

}  // namespace scslam::sim::test
