#include "scslam/core/geodesy.h"

#include <gtest/gtest.h>

#include <cmath>

namespace scslam {
namespace {

using Eigen::Vector3d;

TEST(Geodesy, EnuRoundTripIsBelowAMillimetreWithinATown) {
  for (double latitude : {-90.0, -33.9, 0.0, 36.3721, 90.0}) {
    const LocalEnu enu({latitude, 127.3604, 60});
    for (const Vector3d& p : {Vector3d(0, 0, 0), Vector3d(5000, -3000, 40), Vector3d(-20000, 15000, -100)})
      EXPECT_LT((enu.fromGeodetic(enu.toGeodetic(p)) - p).norm(), 1e-6) << "m at latitude " << latitude;
  }
}

TEST(Geodesy, EnuAxesPointEastNorthAndUp) {
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

TEST(Geodesy, UtmOfAKnownPoint) {
  const Utm utm = toUtm({48, 9, 0});  // on the central meridian of zone 32
  EXPECT_EQ(utm.zone, 32);
  EXPECT_TRUE(utm.north);
  EXPECT_EQ(utm.epsg(), 32632);
  EXPECT_NEAR(utm.easting_m, 500000, 1e-6);
  EXPECT_NEAR(utm.convergence_deg, 0, 1e-9);
  EXPECT_NEAR(utm.scale, 0.9996, 1e-9);
  EXPECT_NEAR(utm.northing_m, 5316300.5, 1000);  // 0.9996 times the meridian arc
  EXPECT_EQ(toUtm({-36.37, 127.36, 0}).epsg(), 32752);
}

TEST(Geodesy, RefusesALatitudeBeyondThePoles) {
  EXPECT_ANY_THROW(LocalEnu({91, 0, 0}));
  EXPECT_ANY_THROW(LocalEnu({std::nan(""), 0, 0}));
}

}  // namespace
}  // namespace scslam
