#include "scslam/core/geodesy.h"

#include <GeographicLib/LocalCartesian.hpp>
#include <GeographicLib/UTMUPS.hpp>

#include "scslam/core/error.h"

namespace scslam {

struct LocalEnu::Projection {
  GeographicLib::LocalCartesian cartesian;
};

LocalEnu::LocalEnu(const Geodetic& origin) {
  if (!(std::abs(origin.latitude_deg) <= 90))
    throw inputError("a latitude of {} degrees lies beyond the poles", origin.latitude_deg);
  projection_ = std::make_shared<const Projection>(
      Projection{GeographicLib::LocalCartesian(origin.latitude_deg, origin.longitude_deg, origin.height_m)});
}

Geodetic LocalEnu::toGeodetic(const Eigen::Vector3d& enu) const {
  Geodetic g;
  projection_->cartesian.Reverse(enu.x(), enu.y(), enu.z(), g.latitude_deg, g.longitude_deg, g.height_m);
  return g;
}

Eigen::Vector3d LocalEnu::fromGeodetic(const Geodetic& g) const {
  Eigen::Vector3d enu;
  projection_->cartesian.Forward(g.latitude_deg, g.longitude_deg, g.height_m, enu.x(), enu.y(), enu.z());
  return enu;
}

Utm toUtm(const Geodetic& g, int zone) {
  Utm utm;
  GeographicLib::UTMUPS::Forward(g.latitude_deg, g.longitude_deg, utm.zone, utm.north, utm.easting_m, utm.northing_m,
                                 utm.convergence_deg, utm.scale, zone < 0 ? GeographicLib::UTMUPS::STANDARD : zone);
  return utm;
}

}  // namespace scslam
