#include "sim/world.h"

#include <algorithm>
#include <cmath>

namespace scslam::sim {

namespace {

/// Point of a polyline at distance s from its start, clamped.
Eigen::Vector3d along(const std::vector<Eigen::Vector3d>& path, double s) {
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const double length = (path[i + 1] - path[i]).norm();
    if (s <= length || i + 2 == path.size())
      return path[i] + (path[i + 1] - path[i]) * std::clamp(length > 0 ? s / length : 0.0, 0.0, 1.0);
    s -= length;
  }
  return path.front();
}

}  // namespace

double Actor::pathLength() const {
  double length = 0;
  for (std::size_t i = 1; i < path.size(); ++i) length += (path[i] - path[i - 1]).norm();
  return length;
}

Pose Actor::at(double t) const {
  constexpr double kReach = 1.5;  // heading: from the rear to the front axle
  const double length = pathLength();
  double s = start_m + speed_mps * t;
  if (length <= 2 * kReach) return poseFromYaw(0, path.front());
  // One that loops drives from end to end and starts anew: it must not appear or vanish within a scan unseen, so paths
  // of loops are closed polylines.
  s = loops ? s - length * std::floor(s / length) : std::clamp(s, kReach, length - kReach);
  const auto wrapped = [&](double x) { return along(path, loops ? x - length * std::floor(x / length) : x); };
  const Eigen::Vector3d rear = wrapped(s - kReach), front = wrapped(s + kReach);
  const Eigen::Vector3d d = front - rear;
  Pose T = poseFromYaw(std::atan2(d.y(), d.x()), (front + rear) / 2);
  T.linear() = T.linear() * Eigen::AngleAxisd(-std::atan2(d.z(), std::hypot(d.x(), d.y())), Eigen::Vector3d::UnitY());
  return T;
}

}  // namespace scslam::sim
