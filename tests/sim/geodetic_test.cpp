#include "sim/geodetic.h"

#include <gtest/gtest.h>

#include <cmath>

namespace scslam::sim {
namespace {

using Eigen::Vector3d;

TEST(Geodetic, AxesOfTheEllipsoidAreThoseOfWgs84) {
  EXPECT_NEAR((toEcef({0, 0, 0}) - Vector3d(6378137.0, 0, 0)).norm(), 0, 1e-6);
  EXPECT_NEAR((toEcef({0, 90, 100}) - Vector3d(0, 6378237.0, 0)).norm(), 0, 1e-6);
  EXPECT_NEAR((toEcef({90, 0, 0}) - Vector3d(0, 0, 6356752.314245)).norm(), 0, 1e-6);
}

TEST(Geodetic, RoundTripIsBelowAMillimetreEverywhere) {
  double worst = 0;
  for (double latitude : {-90.0, -89.9999, -60.0, -1e-7, 0.0, 0.5, 36.37, 45.0, 77.7, 89.999999, 90.0})
    for (double longitude : {-180.0, -77.0, 0.0, 1e-9, 127.36, 179.9999999})
      for (double height : {-10000.0, -430.0, 0.0, 60.0, 8848.0, 400e3, 1e7}) {
        const Vector3d ecef = toEcef({latitude, longitude, height});
        const Geodetic g = fromEcef(ecef);
        worst = std::max(worst, (toEcef(g) - ecef).norm());
        EXPECT_NEAR(g.height_m, height, 1e-6);
        EXPECT_NEAR(g.latitude_deg, latitude, 1e-10);
      }
  EXPECT_LT(worst, 1e-6) << "m";
}

TEST(Geodetic, EnuRoundTripIsBelowAMillimetreWithinATown) {
  for (double latitude : {-90.0, -33.9, 0.0, 36.3721, 90.0}) {
    const LocalEnu enu({latitude, 127.3604, 60});
    for (const Vector3d& p : {Vector3d(0, 0, 0), Vector3d(5000, -3000, 40), Vector3d(-20000, 15000, -100)})
      EXPECT_LT((enu.fromGeodetic(enu.toGeodetic(p)) - p).norm(), 1e-6) << "m at latitude " << latitude;
  }
}

TEST(Geodetic, EnuAxesPointEastNorthAndUp) {
  const Geodetic origin{48, 11, 500};
  const LocalEnu enu(origin);
  const Geodetic east = enu.toGeodetic({100, 0, 0}), north = enu.toGeodetic({0, 100, 0}),
                 up = enu.toGeodetic({0, 0, 100});
  // Radii of curvature of the ellipsoid at the origin: of the parallel, and along the meridian.
  const double s = std::sin(48 * M_PI / 180), e2 = 0.00669437999014, n = 6378137.0 / std::sqrt(1 - e2 * s * s);
  const double meridian = n * (1 - e2) / (1 - e2 * s * s);
  EXPECT_NEAR((east.longitude_deg - 11) * M_PI / 180 * (n + 500) * std::sqrt(1 - s * s), 100, 1e-3);
  EXPECT_NEAR((north.latitude_deg - 48) * M_PI / 180 * (meridian + 500), 100, 2e-3);
  EXPECT_NEAR(up.height_m, 600, 1e-6);
  EXPECT_NEAR(up.latitude_deg, 48, 1e-11);
  // The ellipsoid falls away from the plane that touches it.
  EXPECT_NEAR(east.height_m - 500, 100.0 * 100 / (2 * n), 1e-4);
}

}  // namespace
}  // namespace scslam::sim
