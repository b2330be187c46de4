// What a radar makes of worlds whose image is known in closed form.
#include "sim/radar.h"

#include <algorithm>

#include "radar_fixtures.h"
#include "scslam/sensor/oxford_radar.h"

namespace scslam::sim {
namespace {

using namespace test;
using Eigen::Vector3d;

double rowOfAngle(const RadarModel& model, double azimuth) { return azimuth / (2 * M_PI) * model.azimuths; }

TEST(Radar, MetalBoxShowsAtItsRangeAndAzimuth) {
  const RadarModel model = bare();
  for (const auto& [range, degrees] : {std::pair{30.0, 100.3}, {12.345, 200.0}, {61.01, 359.7}}) {
    MeshBuilder b;
    boxAt(b, range, degrees * M_PI / 180);
    const Peak peak = peakOf(scanOf(model, worldOf(b)));
    EXPECT_NEAR(peak.position, range / model.range_resolution_m, 0.25) << range;
    EXPECT_NEAR(std::remainder(peak.row - rowOfAngle(model, degrees * M_PI / 180), 400), 0, 0.25) << degrees;
  }
}

TEST(Radar, CornerReflectorShowsAtItsApex) {
  RadarModel model = bare();
  model.max_bounces = 3, model.surface_slope_deg = 3;
  MeshBuilder b;
  const double range = 25.02;
  // Three plates at right angles whose diagonal looks back along x.
  const Eigen::Matrix3d R =
      Eigen::Quaterniond::FromTwoVectors(Vector3d(1, 1, 1), -Vector3d::UnitX()).toRotationMatrix();
  const Vector3d apex(range, 0, 0);
  const auto at = [&](double x, double y, double z) { return Vector3d(apex + 0.4 * (R * Vector3d(x, y, z))); };
  b.material("retro_reflector");
  b.quad(at(0, 0, 0), at(1, 0, 0), at(1, 1, 0), at(0, 1, 0));
  b.quad(at(0, 0, 0), at(0, 1, 0), at(0, 1, 1), at(0, 0, 1));
  b.quad(at(0, 0, 0), at(0, 0, 1), at(1, 0, 1), at(1, 0, 0));
  const World world = worldOf(b);
  const Peak peak = peakOf(scanOf(model, world));
  EXPECT_NEAR(peak.position, range / model.range_resolution_m, 0.25);
  EXPECT_NEAR(std::remainder(peak.row, 400), 0, 0.25);
  model.max_bounces = 1;  // each plate alone throws the power elsewhere
  EXPECT_LT(peakOf(scanOf(model, world)).level, peak.level - 10 * model.counts_per_db);
}

TEST(Radar, RangeOffsetIsWhatOneHasToAdd) {
  RadarModel model = bare();
  model.range_offset_m = -0.31;
  MeshBuilder b;
  boxAt(b, 30, 0);
  const RadarScan scan = scanOf(model, worldOf(b));
  const Peak peak = peakOf(scan);
  EXPECT_NEAR(peak.position * model.range_resolution_m, 30.31, 0.011);
  EXPECT_NEAR(scan.rangeAt(peak.position), 30, 0.011);
}

TEST(Radar, ApproachingShortensTheRangeByBetaTimesSpeed) {
  RadarModel model = bare();
  MeshBuilder b;
  boxAt(b, 40, 0);
  const World world = worldOf(b);
  const double start = 0.5, true_range = 40 - 10 * start;
  const Peak peak = peakOf(scanOf(model, world, straight(10), start));
  EXPECT_NEAR(peak.position * model.range_resolution_m, true_range - 0.049 * 10, 0.25 * model.range_resolution_m);
  model.doppler_beta_s = 0;
  EXPECT_NEAR(peakOf(scanOf(model, world, straight(10), start)).position, true_range / model.range_resolution_m, 0.25);
}

TEST(Radar, WhatDrivesAwayLooksFartherByBetaTimesItsSpeed) {
  const RadarModel model = bare();
  MeshBuilder ground, car;
  ground.material("black").box({-100, 0, -50}, 1, 1, 1);
  car.material("metal").box({0, 0, -0.5}, 2, 1, 1);
  World world = worldOf(ground);
  Actor actor;
  actor.mesh = car.take();
  actor.path = {{20, 0, 0}, {300, 0, 0}};
  actor.speed_mps = 8, actor.start_m = 10, actor.loops = false;
  world.actors.push_back(actor);
  EXPECT_NEAR(peakOf(scanOf(model, world)).position * model.range_resolution_m, 29 + 0.049 * 8, 0.011);
}

TEST(Radar, MovingRadarSeesATargetWhereItIsWhenTheBeamPassesIt) {
  RadarModel model = bare();
  model.doppler_beta_s = 0;
  const double v = 20, start = 0.3;
  const Vector3d target(12, 30, 0);
  double azimuth = 0;  // clockwise; the beam meets the target when it points there
  for (int i = 0; i < 50; ++i) {
    const double t = start + azimuth / (2 * M_PI) * model.sweep();
    azimuth = 2 * M_PI - std::atan2(target.y(), target.x() - v * t);
  }
  const double t = start + azimuth / (2 * M_PI) * model.sweep();
  const double range = (target - Vector3d(v * t, 0, 0)).norm();
  const Vector3d away = (target - Vector3d(v * t, 0, 0)) / range;
  MeshBuilder b;
  b.material("metal").box(target + 0.2 * away - Vector3d(0, 0, 0.2), 0.4, 0.4, 0.4, std::atan2(away.y(), away.x()));
  const RadarScan scan = scanOf(model, worldOf(b), straight(v), start);
  const Peak peak = peakOf(scan);
  EXPECT_NEAR(peak.row, rowOfAngle(model, azimuth), 0.25);
  EXPECT_NEAR(peak.position, range / model.range_resolution_m, 0.25);
  const double frozen = rowOfAngle(model, 2 * M_PI - std::atan2(target.y(), target.x() - v * start));
  EXPECT_GT(std::abs(peak.row - frozen), 5);
  EXPECT_NEAR(toSeconds(scan.stamps[300]), start + 0.1875, 1e-6);
}

TEST(Radar, WallsFaceToFaceMakeAGhostAtTheFoldedPath) {
  RadarModel model = bare();
  const double ahead = 10, behind = 6;
  const auto levelAt = [&](double range) {
    MeshBuilder b;
    b.material("metal").box({ahead + 0.5, 0, -10}, 1, 60, 20);
    b.material("metal").box({-behind - 0.5, 0, -10}, 1, 60, 20);
    const RadarScan scan = scanOf(model, worldOf(b));
    const auto row = scan.row(0);
    const auto from = static_cast<std::ptrdiff_t>((range - 1) / model.range_resolution_m);
    const auto top = std::max_element(row.begin() + from, row.begin() + from + 46);
    EXPECT_TRUE(*top == 0 || std::abs((static_cast<double>(top - row.begin()) + 0.5) * 0.0438 - range) < 0.1);
    return static_cast<int>(*top);
  };
  const double ghost = 2 * ahead + behind;  // there, back past the radar to the other wall, and all the way again
  EXPECT_EQ(levelAt(ghost), 0);
  model.max_bounces = 3;
  EXPECT_GT(levelAt(ghost), 60);
}

TEST(Radar, PointsFallWithTheFourthPowerAndWallsWithTheSecond) {
  RadarModel model = bare();
  model.rays_per_azimuth = 3000;
  const auto level = [&](double range, double size) {
    MeshBuilder b;
    boxAt(b, range, 0, size);
    return peakOf(scanOf(model, worldOf(b))).level / model.counts_per_db;
  };
  EXPECT_NEAR(level(15, 0.25) - level(45, 0.25), 40 * std::log10(3.0), 1.0);
  EXPECT_NEAR(level(15, 60) - level(45, 60), 20 * std::log10(3.0), 1.0);
}

TEST(Radar, BeamIsAsWideAsItsModelSays) {
  RadarModel model = bare();
  model.rays_per_azimuth = 3000;
  MeshBuilder b;
  boxAt(b, 30, 0, 0.1);
  const RadarScan scan = scanOf(model, worldOf(b));
  const auto bin = static_cast<std::size_t>(30 / model.range_resolution_m);
  // Two ways through a Gaussian of 1.8 deg half-power width: 10 log10 exp(-2 x^2 / 2 sigma^2) dB at 0.9 deg.
  const double sigma = 1.8 / std::sqrt(8 * std::log(2.0)),
               expected = 10 * std::log10(std::exp(-0.81 / (sigma * sigma)));
  EXPECT_NEAR((scan.row(1)[bin] - scan.row(0)[bin]) / model.counts_per_db, expected, 0.6);
  EXPECT_NEAR((scan.row(399)[bin] - scan.row(0)[bin]) / model.counts_per_db, expected, 0.6);
}

TEST(Radar, SameBytesForAnyNumberOfThreadsAndOthersForAnotherSeedOrScan) {
  RadarModel model = shipped();
  model.rays_per_azimuth = 48;
  const World world = aStreet();
  const auto bytes = [&](std::uint64_t seed, std::uint32_t number, int threads) {
    return encodeOxfordRadar(scanOf(model, world, straight(8), 0.2, seed, number, threads));
  };
  const std::string first = bytes(1, 0, 1);
  EXPECT_EQ(first, bytes(1, 0, 2));
  EXPECT_NE(first, bytes(2, 0, 2));
  EXPECT_NE(first, bytes(1, 1, 2));
}

TEST(Radar, RowsAreStampedAndTurnedEvenly) {
  MeshBuilder b;
  boxAt(b, 30, 0);
  const RadarModel model = shipped("cir204-h");
  const RadarScan scan = scanOf(model, worldOf(b), straight(), 1.5);
  ASSERT_TRUE(scan.consistent());
  EXPECT_EQ(scan.azimuths, 400U);
  EXPECT_EQ(scan.bins, 3360U);
  EXPECT_NEAR(secondsBetween(scan.stamps[0], scan.stamps[399]), 0.25 * 399 / 400, 1e-6);
  EXPECT_DOUBLE_EQ(scan.angles[100], M_PI / 2);
  EXPECT_EQ(scan.range_offset_m, -0.31);
  EXPECT_THAT(scan.T_base_sensor, scslam::test::IsNear(model.T_base_sensor(), 1e-12, 1e-9));
  const RadarScan again = decodeOxfordRadar(encodeOxfordRadar(scan), "again");
  EXPECT_EQ(again.power, scan.power);
  EXPECT_DOUBLE_EQ(again.angles[399], scan.angles[399]);
}

TEST(Radar, NonsenseIsRefused) {
  RadarModel model;
  EXPECT_THROW(loadYaml(model, "azimuth: 3", "a"), Error);
  EXPECT_THROW(loadYaml(model, "noise: .nan", "a"), Error);
  model.rpy_deg = {1};
  EXPECT_THROW(Radar(model, 1), Error);
  model = RadarModel();
  model.azimuths = 5600, model.rays_per_azimuth = 100000;
  EXPECT_THROW(Radar(model, 1), Error);
  MeshBuilder b;
  boxAt(b, 30, 0);
  EXPECT_THROW(scanOf(bare(), worldOf(b), straight(), std::nan("")), Error);
  EXPECT_THROW(scanOf(bare(), worldOf(b), straight(std::nan(""))), Error);
}

}  // namespace
}  // namespace scslam::sim
