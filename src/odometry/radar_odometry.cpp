#include "scslam/odometry/radar_odometry.h"

#include <cmath>

#include "scslam/core/deskew.h"

namespace scslam {

void RadarOdometryParams::describeRadar(ParamVisitor& visitor) {
  describeShared(visitor);
  visitor.field("climb", climb, "one sigma of the height gained over a step, as a share of its length", 1e-4, 10.0);
  visitor.field("tilt_deg", tilt_deg, "one sigma of roll and pitch over a step [deg]", 1e-3, 90.0);
}

void RadarOdometry::noteSensor(const Scan& scan) {
  T_base_sensor_ = scan.T_base_sensor;
  doppler_beta_s_ = scan.radar ? scan.radar->doppler_beta_s : 0.0;
}

void RadarOdometry::compensate(Cloud& cloud, const Vector6d& twist) const {
  undoDoppler(cloud, T_base_sensor_, doppler_beta_s_, twist);
  deskew(cloud, twist);
}

ScanToMap::OffPlane RadarOdometry::offPlane(const Pose& T_previous_base) const {
  constexpr double kLeast = 0.01;  // [m]
  return {kLeast + climb_ * T_previous_base.translation().norm(), tilt_deg_ * M_PI / 180};
}

void undoDoppler(Cloud& cloud, const Pose& T_base_sensor, double doppler_beta_s, const Vector6d& twist) {
  if (doppler_beta_s == 0 || twist.isZero()) return;
  const Eigen::Vector3d origin = T_base_sensor.translation();
  const Eigen::Vector3d v = twist.head<3>(), w = twist.tail<3>(), lever = w.cross(origin);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double dt = cloud.hasTime() && std::isfinite(cloud.dt[i]) ? static_cast<double>(cloud.dt[i]) : 0.0;
    const Eigen::Vector3d ray = cloud.point(i).cast<double>() - origin;
    const double range = ray.norm();
    if (!(range > 0)) continue;
    // deskew() moves the base along a straight line (v is fixed in frame base at the stamp) while it turns.
    const Eigen::Vector3d velocity = v + w.cross(-dt * v) + lever;
    const Eigen::Vector3d shift = doppler_beta_s * velocity.dot(ray) / (range * range) * ray;
    cloud.x[i] += static_cast<float>(shift.x()), cloud.y[i] += static_cast<float>(shift.y()),
        cloud.z[i] += static_cast<float>(shift.z());
  }
}

}  // namespace scslam
