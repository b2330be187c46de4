#include "sim/gnss.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationGPS.h>

#include "drives.h"
#include "scslam/core/error.h"
#include "sim/mesh_builder.h"
#include "sim/ray_scene.h"

namespace scslam::sim {
namespace {

using Eigen::Vector3d;
using mrpt::obs::CObservationGPS;
using mrpt::obs::gnss::Message_NMEA_GGA;
using test::emitted;
using test::start;

GnssModel quiet() {
  GnssModel model;
  model.horizontal_sigma_m = model.vertical_sigma_m = 0;
  model.multipath_per_s = 0;
  return model;
}

Vector3d enuOf(const CObservationGPS& o, const GnssModel& model) {
  const auto& gga = o.getMsgByClass<Message_NMEA_GGA>().fields;
  return LocalEnu({model.latitude_deg, model.longitude_deg, model.height_m})
      .fromGeodetic({gga.latitude_degrees, gga.longitude_degrees, gga.altitude_meters});
}

TEST(Gnss, WithoutErrorsItGivesThePlaceOfTheAntenna) {
  const Trajectory trajectory = test::lively();
  GnssModel model = quiet();
  model.translation_m = {-0.5, 0.2, 1.8};
  Gnss gnss(model, trajectory, 1, start());
  const auto fixes = emitted<CObservationGPS>(gnss);
  ASSERT_EQ(fixes.size(), 151U);
  for (const auto& o : fixes) {
    const Vector3d antenna = trajectory.pose(secondsBetween(start(), o->timestamp)) * Vector3d(-0.5, 0.2, 1.8);
    EXPECT_LT((enuOf(*o, model) - antenna).norm(), 1e-6);
    EXPECT_DOUBLE_EQ(o->sensorPose.z(), 1.8);
  }
}

TEST(Gnss, GgaCarriesTimeQualitySatellitesAndDilution) {
  const Trajectory trajectory = test::parked(100);
  Gnss gnss(quiet(), trajectory, 1, start());
  const auto fixes = emitted<CObservationGPS>(gnss);
  ASSERT_TRUE(fixes[0]->has_GGA_datum());
  const auto& first = fixes[0]->getMsgByClass<Message_NMEA_GGA>().fields;
  EXPECT_EQ(first.UTCTime.hour, 10);
  EXPECT_EQ(first.UTCTime.minute, 20);
  EXPECT_NEAR(first.UTCTime.sec, 30, 1e-7);
  EXPECT_EQ(first.fix_quality, 2);
  EXPECT_EQ(first.satellitesUsed, 12U);
  EXPECT_TRUE(first.thereis_HDOP);
  EXPECT_FLOAT_EQ(first.HDOP, 0.9F);
  const auto& later = fixes[152]->getMsgByClass<Message_NMEA_GGA>().fields;  // 30.4 s after
  EXPECT_EQ(later.UTCTime.minute, 21);
  EXPECT_NEAR(later.UTCTime.sec, 0.4, 1e-6);
}

TEST(Gnss, NoiseHasItsSigmas) {
  const Trajectory trajectory = test::parked(2000);
  GnssModel model = quiet();
  model.horizontal_sigma_m = 0.6, model.vertical_sigma_m = 1.5;
  Gnss gnss(model, trajectory, 3, start());
  std::array<std::vector<double>, 3> axis;
  for (const auto& o : emitted<CObservationGPS>(gnss)) {
    const Vector3d p = enuOf(*o, model);
    for (int k = 0; k < 3; ++k) axis[k].push_back(p[k]);
  }
  EXPECT_MOMENTS(axis[0], 0, 0.6);
  EXPECT_MOMENTS(axis[1], 0, 0.6);
  EXPECT_MOMENTS(axis[2], 0, 1.5);
}

TEST(Gnss, MultipathInABurstIsAGaussMarkovProcess) {
  const Trajectory trajectory = test::parked(40000);
  GnssModel model = quiet();
  model.rate_hz = 1;
  model.multipath_per_s = 1000, model.multipath_s = 1e6;  // always in a burst, but for a moment at a time
  model.multipath_sigma_m = 4, model.multipath_tau_s = 5;
  Gnss gnss(model, trajectory, 2, start());
  std::vector<double> east;
  for (const auto& o : emitted<CObservationGPS>(gnss)) east.push_back(enuOf(*o, model).x());
  // 40 000 s hold about 40 000 / (2 tau) = 4000 independent numbers: 3 sigma of the deviation are 3.4 %.
  EXPECT_NEAR(test::momentsOf(east).sigma, 4, 0.034 * 4);
  double lag_5 = 0, lag_0 = 0;
  for (std::size_t k = 0; k + 5 < east.size(); ++k) lag_5 += east[k] * east[k + 5], lag_0 += east[k] * east[k];
  EXPECT_NEAR(lag_5 / lag_0, std::exp(-1), 0.05);
}

TEST(Gnss, MultipathComesInBursts) {
  const Trajectory trajectory = test::parked(100000);
  GnssModel model = quiet();
  model.rate_hz = 1;
  model.multipath_per_s = 0.01, model.multipath_s = 20, model.multipath_tau_s = 1;
  Gnss gnss(model, trajectory, 2, start());
  int disturbed = 0, fixes = 0;
  for (const auto& o : emitted<CObservationGPS>(gnss)) {
    ++fixes;
    disturbed += enuOf(*o, model).norm() > 0.5 ? 1 : 0;
  }
  // 20 s in 120 s, plus the time it takes to die away (from about 5 m to 0.5 m: 2.3 tau).
  EXPECT_NEAR(static_cast<double>(disturbed) / fixes, 22.0 / 120, 0.03);
}

TEST(Gnss, ListedOutagesHaveNoFixAndChangeNoOther) {
  const Trajectory trajectory = test::parked(20);
  GnssModel model;
  Gnss whole(model, trajectory, 9, start());
  model.outages_s = {2, 5, 10, 10.5};
  Gnss gnss(model, trajectory, 9, start());
  const auto all = emitted<CObservationGPS>(whole), fixes = emitted<CObservationGPS>(gnss);
  ASSERT_EQ(all.size(), 101U);
  EXPECT_EQ(fixes.size(), all.size() - 16 - 3);
  for (const auto& o : fixes) {
    const double t = secondsBetween(start(), o->timestamp);
    EXPECT_FALSE((t >= 2 && t <= 5) || (t >= 10 && t <= 10.5)) << t;
    EXPECT_EQ(enuOf(*o, model), enuOf(*all[static_cast<std::size_t>(std::lround(t * 5))], model));
  }
}

TEST(Gnss, OutagesThatAreNoPairsAreAUsageError) {
  const Trajectory trajectory = test::parked(1);
  for (const std::vector<double>& bad : {std::vector<double>{1}, {5, 4}, {1, 2, std::nan(""), 4}}) {
    GnssModel model;
    model.outages_s = bad;
    EXPECT_THROW(Gnss(model, trajectory, 1, start()), Error);
  }
}

/// A roof 100 m wide and 10 m above the way from x = 50 to x = 150; ground below.
World roofed() {
  MeshBuilder builder;
  builder.terrain(-100, -100, 300, 100, 50, [](double, double) { return 0; });
  builder.box(Vector3d(100, 0, 10), 100, 100, 1);
  return {"roofed", builder.take(), {}, {}};
}

TEST(Gnss, LosesTheFixUnderARoof) {
  const World world = roofed();
  const RayScene scene(world);
  std::vector<Pose> control;
  for (int i = 0; i < 4; ++i) control.push_back(poseFromYaw(0, {200.0 * (i - 1), 0, 1}));
  const Trajectory trajectory(control, 20);
  const GnssModel model = quiet();
  Gnss gnss(model, trajectory, 1, start(), &scene);
  EXPECT_EQ(gnss.openSky({-80, 0, 1.5}), 1);
  EXPECT_LT(gnss.openSky({100, 0, 1.5}), 0.15);
  bool lost = false, worse = false;
  for (double x = 0, last = -2; const auto& o : emitted<CObservationGPS>(gnss)) {
    x = enuOf(*o, model).x();
    EXPECT_FALSE(x > 75 && x < 125) << "a fix under the roof, at x = " << x;
    lost = lost || x - last > 50;
    last = x;
    const auto& gga = o->getMsgByClass<Message_NMEA_GGA>().fields;
    worse = worse || (gga.satellitesUsed < 9 && gga.HDOP > 1);
  }
  EXPECT_TRUE(lost);
  EXPECT_TRUE(worse) << "no fix near the roof's edge has fewer satellites";
  GnssModel open = model;
  open.sky_rays = 0;
  Gnss blind_to_roofs(open, trajectory, 1, start(), &scene);
  EXPECT_EQ(emitted<CObservationGPS>(blind_to_roofs).size(), 101U);
}

TEST(Gnss, OpenSkyUnderAHalfPlaneIsHalf) {
  MeshBuilder builder;  // a wall along the antenna, tall and long: one half of the sky
  builder.box(Vector3d(0, 200.1, -1), 4000, 400, 4000);
  const World world{"wall", builder.take(), {}, {}};
  const RayScene scene(world);
  const Trajectory trajectory = test::parked(1);
  GnssModel model = quiet();
  model.sky_rays = 1000;
  EXPECT_NEAR(Gnss(model, trajectory, 1, start(), &scene).openSky({0, 0, 1}), 0.5, 0.01);
}

TEST(Gnss, SameSeedSameFixesHoweverTheLoopAsks) {
  const Trajectory trajectory = test::lively();
  GnssModel model;
  model.multipath_per_s = 0.2;
  Gnss at_once(model, trajectory, 4, start()), in_steps(model, trajectory, 4, start()),
      other(model, trajectory, 5, start());
  const auto a = emitted<CObservationGPS>(at_once), c = emitted<CObservationGPS>(other);
  std::vector<std::shared_ptr<const CObservationGPS>> b;
  for (double t = 0; t < 31; t += 0.77)
    for (const auto& o : emitted<CObservationGPS>(in_steps, t)) b.push_back(o);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(enuOf(*a[k], model), enuOf(*b[k], model));
    EXPECT_NE(enuOf(*a[k], model), enuOf(*c[k], model));
  }
}

}  // namespace
}  // namespace scslam::sim
