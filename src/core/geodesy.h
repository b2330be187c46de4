// Latitude, longitude and height on the WGS-84 ellipsoid, a local east-north-up frame at an origin on it, and UTM.
#pragma once
#include <Eigen/Core>
#include <memory>

namespace scslam {

struct Geodetic {
  double latitude_deg = 0;   ///< north positive, -90 … 90
  double longitude_deg = 0;  ///< east positive, -180 … 180
  double height_m = 0;       ///< above the ellipsoid
};

/// East, north, up [m] on the plane that touches the ellipsoid at the origin's latitude and longitude, at its height.
class LocalEnu {
 public:
  /// @throw inputError for a latitude beyond the poles.
  explicit LocalEnu(const Geodetic& origin);
  Geodetic toGeodetic(const Eigen::Vector3d& enu) const;
  Eigen::Vector3d fromGeodetic(const Geodetic& g) const;

 private:
  struct Projection;
  std::shared_ptr<const Projection> projection_;
};

/// Universal transverse Mercator (polar stereographic beyond 84 N and 80 S, zone 0).
struct Utm {
  int zone = 0;
  bool north = true;
  double easting_m = 0, northing_m = 0;
  double convergence_deg = 0;  ///< bearing of grid north, clockwise from true north
  double scale = 1;            ///< grid distance / distance on the ellipsoid
  int epsg() const { return zone == 0 ? (north ? 32661 : 32761) : (north ? 32600 : 32700) + zone; }
};
/// @param zone of which the coordinates are to be, even a little outside of it; negative: the one that g lies in.
Utm toUtm(const Geodetic& g, int zone = -1);

}  // namespace scslam
