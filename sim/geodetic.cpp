#include "sim/geodetic.h"

#include <Eigen/Geometry>

#include <cmath>

namespace scslam::sim {

namespace {

// WGS-84: NIMA TR8350.2.
constexpr double kA = 6378137.0, kF = 1 / 298.257223563, kB = kA * (1 - kF), kE2 = kF * (2 - kF);
constexpr double kDeg = M_PI / 180;

}  // namespace

Eigen::Vector3d toEcef(const Geodetic& g) {
  const double lat = g.latitude_deg * kDeg, lon = g.longitude_deg * kDeg;
  const double n = kA / std::sqrt(1 - kE2 * std::sin(lat) * std::sin(lat));
  const double across = (n + g.height_m) * std::cos(lat);
  return {across * std::cos(lon), across * std::sin(lon), (n * (1 - kE2) + g.height_m) * std::sin(lat)};
}

Geodetic fromEcef(const Eigen::Vector3d& ecef) {
  const double p = std::hypot(ecef.x(), ecef.y()), z = ecef.z();
  // Of the reduced latitude b, only sine and cosine are needed; both stay valid at the poles.
  double lat = std::atan2(z * kA, p * kB);
  for (int i = 0; i < 3; ++i) {
    const double b = i == 0 ? lat : std::atan2((1 - kF) * std::sin(lat), std::cos(lat));
    lat = std::atan2(z + kE2 / (1 - kE2) * kB * std::pow(std::sin(b), 3), p - kE2 * kA * std::pow(std::cos(b), 3));
  }
  const double height = p * std::cos(lat) + z * std::sin(lat) - kA * std::sqrt(1 - kE2 * std::sin(lat) * std::sin(lat));
  return {lat / kDeg, std::atan2(ecef.y(), ecef.x()) / kDeg, height};
}

LocalEnu::LocalEnu(const Geodetic& origin) : origin_ecef_(toEcef(origin)) {
  const double lat = origin.latitude_deg * kDeg, lon = origin.longitude_deg * kDeg;
  R_ecef_enu_.col(0) << -std::sin(lon), std::cos(lon), 0;
  R_ecef_enu_.col(2) << std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat);
  R_ecef_enu_.col(1) = R_ecef_enu_.col(2).cross(R_ecef_enu_.col(0));
}

Geodetic LocalEnu::toGeodetic(const Eigen::Vector3d& enu) const { return fromEcef(origin_ecef_ + R_ecef_enu_ * enu); }

Eigen::Vector3d LocalEnu::fromGeodetic(const Geodetic& g) const {
  return R_ecef_enu_.transpose() * (toEcef(g) - origin_ecef_);
}

}  // namespace scslam::sim
