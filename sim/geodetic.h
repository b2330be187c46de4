// Latitude, longitude and height on the WGS-84 ellipsoid, and a local east-north-up frame at an origin on it.
#pragma once
#include <Eigen/Core>

namespace scslam::sim {

struct Geodetic {
  double latitude_deg = 0;   ///< north positive, -90 … 90
  double longitude_deg = 0;  ///< east positive, -180 … 180
  double height_m = 0;       ///< above the ellipsoid
};

/// Earth-centred, earth-fixed [m].
Eigen::Vector3d toEcef(const Geodetic& g);
/// Inverse of toEcef by Bowring's iteration (1976); exact to nanometres from 10 km below the ellipsoid to 10 000 km
/// above.
Geodetic fromEcef(const Eigen::Vector3d& ecef);

/// East, north, up [m] on the plane that touches the ellipsoid at the origin's latitude and longitude, at its height.
class LocalEnu {
 public:
  explicit LocalEnu(const Geodetic& origin);
  Geodetic toGeodetic(const Eigen::Vector3d& enu) const;
  Eigen::Vector3d fromGeodetic(const Geodetic& g) const;

 private:
  Eigen::Vector3d origin_ecef_;
  Eigen::Matrix3d R_ecef_enu_;
};

}  // namespace scslam::sim
