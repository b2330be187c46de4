#include "sim/realism.h"

#include <nlohmann/json.hpp>

#include "scslam/core/error.h"
#include "scslam/sensor/scan_source.h"
#include "sim/embedded_targets.h"
#include "sim/kd_tree.h"
#include "sim/realism_score.h"
#include "sim/synthetic_scans.h"
#include "support/support.h"

namespace scslam::test {
namespace {

using namespace scslam::sim;
using ::testing::Each;
using ::testing::HasSubstr;

RealismFigures measuredFrom(const PipeScan& pipe, const SensorModel& sensor = aSensor(), int scans = 6) {
  RealismMeter meter(sensor);
  for (int i = 0; i < scans; ++i) meter.add(scanOf(pipe, sensor, static_cast<std::uint32_t>(i + 1)));
  return meter.figures();
}

// ==== The range image ====

TEST(RangeImage, KnowsTheRingsAsGivenByRowsAndByElevationAlike) {
  const SensorModel sensor = aSensor();
  const Cloud given = scanOf({}, sensor);
  Cloud rows = given, shuffled;
  rows.ring.clear();
  for (int column = 0; column < sensor.columns; ++column)  // column by column: rows cannot be told
    for (int ring = 0; ring < sensor.rings; ++ring)
      shuffled.pushFrom(rows, static_cast<std::size_t>(ring * sensor.columns + column));
  const RangeImage a = organise(given, sensor), b = organise(rows, sensor), c = organise(shuffled, sensor);
  EXPECT_EQ(a.ring_source, RingSource::kGiven);
  EXPECT_EQ(b.ring_source, RingSource::kRows);
  EXPECT_EQ(c.ring_source, RingSource::kElevation);
  EXPECT_EQ(a.point, b.point);
  EXPECT_EQ(a.range_m, b.range_m);
  EXPECT_EQ(a.range_m, c.range_m);
}

TEST(RangeImage, RefusesWhatTheTableCannotHold) {
  Cloud cloud = scanOf({}, aSensor());
  SensorModel few = aSensor(8), silent = aSensor();
  EXPECT_THROW(organise(cloud, few), Error);
  silent.elevation_deg.clear();
  EXPECT_NO_THROW(organise(cloud, silent)) << "the points say their rings";
  cloud.ring.clear();
  std::swap(cloud.x[3], cloud.x[9000]), std::swap(cloud.y[3], cloud.y[9000]);
  EXPECT_THROW(organise(cloud, silent), Error);
}

TEST(RangeImage, PointsWithoutAReturnAreNone) {
  Cloud cloud = scanOf({}, aSensor());
  cloud.x[0] = cloud.y[0] = cloud.z[0] = 0;
  cloud.x[1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(organise(cloud, aSensor()).offered, cloud.size() - 2);
}

// ==== Figures with known answers ====

TEST(Realism, NoiseOfTheRangeIsMeasured) {
  for (const double sigma : {0.005, 0.02, 0.05}) {
    const auto figures = measuredFrom({.ground_m = 0, .noise_m = sigma, .quantum_m = 0});
    EXPECT_NEAR(figures.range_noise_m[2], sigma, 0.05 * sigma) << "10-15 m";
    EXPECT_FALSE(measured(figures.range_noise_m[0])) << "no returns at 2-5 m";
  }
}

TEST(Realism, UnevennessOfThePlaneIsMeasured) {
  const SensorModel sensor = aSensor(64);
  PipeScan pipe{.radius_m = 40, .quantum_m = 0};
  Cloud cloud = scanOf(pipe, sensor);
  std::mt19937 random(5);
  std::normal_distribution<float> bump(0.0f, 0.01f);
  for (float& z : cloud.z) z += bump(random);
  RealismMeter meter(sensor);
  ASSERT_TRUE(meter.add(cloud));
  const auto figures = meter.figures();
  EXPECT_NEAR(figures.ground_height_m, -1.7, 0.051);
  EXPECT_NEAR(figures.ground_plane_std_m, 0.01, 0.001);
  EXPECT_NEAR(figures.ground_plane_mad_m, 0.01, 0.0015);
  EXPECT_LT(figures.ground_slope_deg, 1);
}

TEST(Realism, DropOutRateIsMeasuredByRangeAndSignal) {
  const auto figures = measuredFrom({.ground_m = 0, .dropout = 0.02, .weak_dropout = 0.2}, aSensor(32));
  EXPECT_NEAR(figures.dropout_by_range[0], 0.091, 0.01);  // pairs of neighbours that return are fewer where it is weak
  EXPECT_FALSE(measured(figures.dropout_by_range[1]));
  EXPECT_NEAR(figures.dropout_by_signal[2], 0.2, 0.01) << "8-10 counts";
  EXPECT_NEAR(figures.dropout_by_signal[8], 0.02, 0.002) << "50-80 counts";
  EXPECT_FALSE(measured(figures.dropout_by_signal[5]));
}

TEST(Realism, IntensityThatIsNoSignalGivesNoDropOutBySignal) {
  const SensorModel sensor = aSensor();
  const Cloud plain = scanOf({}, sensor);
  const auto why = [&](auto change) {
    Cloud cloud = plain;
    change(cloud);
    RealismMeter meter(sensor);
    meter.add(cloud);
    EXPECT_TRUE(meter.figures().dropout_by_signal.empty());
    return meter.whyNoSignal();
  };
  EXPECT_THAT(why([](Cloud& c) { c.intensity.clear(); }), HasSubstr("no intensity"));
  EXPECT_THAT(why([](Cloud& c) { c.intensity.assign(c.size(), 7); }), HasSubstr("equal"));
  EXPECT_THAT(why([](Cloud& c) {
                for (float& i : c.intensity) i /= 100;
              }),
              HasSubstr("counts"));
  EXPECT_THAT(why([](Cloud& c) {
                for (std::size_t i = 0; i < c.size(); ++i) c.intensity[i] = c.ring[i] + c.dt[i];
              }),
              HasSubstr("ring"));
}

TEST(Realism, TheGridOfTheSensorIsFound) {
  const auto figures = measuredFrom({.noise_m = 0.02});
  EXPECT_LT(figures.elevation_off_deg, 1e-4);
  EXPECT_LT(figures.azimuth_off_step, 1e-3);
  EXPECT_LT(figures.azimuth_drift_step, 1e-3);
  EXPECT_DOUBLE_EQ(figures.range_quantum_m, 0.001);
  EXPECT_NEAR(figures.column_time_s, -0.1 / 1024, 1e-8) << "clockwise";
  EXPECT_EQ(measuredFrom({.noise_m = 0.02, .quantum_m = 0}).range_quantum_m, 0);
  EXPECT_DOUBLE_EQ(measuredFrom({.noise_m = 0.02, .quantum_m = 0.004}).range_quantum_m, 0.004);
}

TEST(Realism, BlindColumnsAreCounted) {
  const SensorModel sensor = aSensor();
  Cloud cloud = scanOf({}, sensor);
  std::vector<std::uint8_t> keep;
  for (std::size_t i = 0; i < cloud.size(); ++i) keep.push_back(i % 1024 >= 100);
  cloud.filter(keep);
  RealismMeter meter(sensor);
  meter.add(cloud);
  const auto figures = meter.figures();
  EXPECT_EQ(figures.columns_never_seen, 100);
  EXPECT_THAT(figures.ring_never_seen, Each(100));
  EXPECT_THAT(figures.ring_rate_seen, Each(1));
  EXPECT_NEAR(figures.return_rate, 924.0 / 1024, 1e-12);
}

TEST(Realism, AnEmptyScanCountsForNothing) {
  RealismMeter meter(aSensor());
  EXPECT_FALSE(meter.add({}));
  EXPECT_EQ(meter.skipped(), 1u);
  EXPECT_EQ(meter.figures().scans, 0);
  EXPECT_FALSE(measured(meter.figures().points));
}

TEST(KdTree, FindsWhatASearchThroughAllFinds) {
  const Cloud room = aRoom(600);
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < room.size(); ++i) points.push_back(room.point(i).cast<double>());
  points.push_back(points[7]);
  const KdTree tree(points);
  std::vector<std::uint32_t> found;
  for (std::size_t i = 0; i < points.size(); i += 13) {
    double nearest = std::numeric_limits<double>::infinity();
    std::vector<std::uint32_t> near;
    for (std::size_t j = 0; j < points.size(); ++j) {
      const double distance = (points[i] - points[j]).norm();
      if (i != j) nearest = std::min(nearest, distance);
      if (distance <= 1.0) near.push_back(static_cast<std::uint32_t>(j));
    }
    EXPECT_DOUBLE_EQ(tree.nearestOther(i), nearest);
    tree.within(points[i], 1.0, found);
    EXPECT_THAT(found, ::testing::UnorderedElementsAreArray(near));
  }
  EXPECT_EQ(tree.nearestOther(7), 0);
}

// ==== A real recording ====

RealismTarget shipped(const std::string& name) { return loadRealismTarget(embeddedTargets().at(name), name); }

TEST(RealismOfSeosan01, AgreesWithTheShippedFiguresAndScoresOne) {
  SCSLAM_NEEDS_DATA(folder, "scaloam_session_Seosan01");
  const RealismTarget target = shipped("seosan01_os1-128");
  RealismMeter meter(target.sensor);
  const auto opened = openSource(folder, context());
  while (const auto scan = opened.source->next()) meter.add(scan->cloud);
  const RealismFigures figures = meter.figures();
  EXPECT_EQ(figures.scans, 21);
  // Computed independently by the script that the figures were first defined with.
  EXPECT_NEAR(figures.points, 58708, 2);
  EXPECT_NEAR(figures.range_noise_m[1], 0.0102774, 1e-6);
  EXPECT_NEAR(figures.dropout, 0.0203040, 1e-4);
  EXPECT_NEAR(figures.jump, 0.1091987, 1e-6);
  EXPECT_NEAR(figures.mixed_pixels_per_jump, 0.1453375, 1e-6);
  EXPECT_NEAR(figures.ground_plane_std_m, 0.0351301, 1e-6);
  EXPECT_NEAR(figures.spacing_per_azimuth_step, 0.9991796, 1e-6);
  EXPECT_NEAR(figures.linear_planar_scatter[1], 0.6613493, 1e-6);
  EXPECT_NEAR(figures.sc_occupancy, 0.5191667, 1e-6);
  for (const Score& score : scoreRealism(figures, meter.sensor(), target)) {
    ASSERT_TRUE(score.value) << score.name << ": " << score.note;
    EXPECT_GT(*score.value, 0.999) << score.name << ": " << score.note;
  }
}

TEST(RealismVerb, ChoosesTheRealSetAndTellsTheSameInJsonAndTable) {
  SCSLAM_NEEDS_DATA(folder, "scaloam_session_Seosan01");
  const RunResult run = runScslam("realism " + folder.string() + " --max 5 --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json["like"], "seosan01_os1-128");
  EXPECT_EQ(json["scans"], 5);
  ASSERT_EQ(json["scores"].size(), 6u);
  EXPECT_EQ(json["scores"][0]["value"], 1);
  EXPECT_EQ(json["figures"]["points"]["target"], 58709);
  const RunResult table = runScslam("realism " + folder.string() + " --max 5");
  EXPECT_THAT(table.out, HasSubstr("local geometry"));
  EXPECT_EQ(runScslam("realism " + folder.string() + " --like seosan").exit_code, 2);
}

TEST(RealismVerb, WhatItSavesIsARealSet) {
  SCSLAM_NEEDS_DATA(folder, "scaloam_session_Seosan01");
  const auto file = freshFolder() / "mine.yaml";
  ASSERT_EQ(runScslam("realism " + folder.string() + " --max 5 --save " + file.string()).exit_code, 0);
  const RunResult run = runScslam("realism " + folder.string() + " --max 5 --json --like " + file.string());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json["like"], "mine");
  for (const auto& score : json["scores"]) EXPECT_GT(score["value"].get<double>(), 0.999) << score;
}

}  // namespace
}  // namespace scslam::test
