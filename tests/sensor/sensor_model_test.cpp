#include "scslam/sensor/sensor_model.h"

#include <cmath>
#include <limits>

#include "fixtures.h"
#include "scslam/sensor/preprocess.h"
#include "scslam/sensor/sensor_tables.h"

namespace scslam {
namespace {

using testing::HasSubstr;

TEST(SensorTables, AllLoadAndAreConsistent) {
  EXPECT_THAT(sensorModelNames(), testing::IsSupersetOf({"hdl32", "hdl64", "mulran_os1-64", "os1-128", "os1-64",
                                                         "pandar64", "sick_lms", "vlp16"}));
  for (const std::string& name : sensorModelNames()) {
    const SensorModel sensor = loadSensorModel(name);
    EXPECT_NE(sensor.name, "unknown") << name;
    EXPECT_TRUE(sensor.rings > 0 || sensor.radar.range_resolution_m > 0) << name;
  }
  EXPECT_DOUBLE_EQ(loadSensorModel("vlp16").elevation_deg.front(), -15);
  EXPECT_DOUBLE_EQ(loadSensorModel("mulran_os1-64").elevation_deg.back(), 17.84);
}

TEST(SensorTables, UnknownNamesGetASuggestion) {
  try {
    loadSensorModel("vlp-16");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kUsage);
    EXPECT_THAT(error.what(), HasSubstr("did you mean 'vlp16'?"));
  }
}

TEST(SensorTables, AUsersFileIsCheckedWithItsName) {
  const auto file = test::freshFolder() / "mine.yaml";
  const auto message = [&file](const std::string& yaml) {
    test::writeBytes(file, yaml);
    try {
      loadSensorModel(file.string());
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(message("rings: 2\nelevation_deg: [-1, 1]\n"), "");
  EXPECT_THAT(message("rings: 2\nelevation_deg: [-1]\n"),
              HasSubstr("mine.yaml: elevation_deg has 1 entries for 2 rings"));
  EXPECT_THAT(message("rings: 2\nelevation_deg: [1, -1]\n"), HasSubstr("must rise"));
  EXPECT_THAT(message("rpy_deg: [0, 0]\n"), HasSubstr("three entries"));
}

TEST(SensorModel, ExtrinsicTurnsAboutFixedAxesRollPitchYaw) {
  SensorModel sensor;
  sensor.translation_m = {1, 2, 3};
  sensor.rpy_deg = {90, 0, 90};
  const Pose T = sensor.T_base_sensor();
  EXPECT_LT((T * Eigen::Vector3d(0, 1, 0) - Eigen::Vector3d(1, 2, 4)).norm(), 1e-12);  // roll lifts y to z
  EXPECT_LT((T * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, 3, 3)).norm(), 1e-12);  // yaw turns x to y
}

SensorModel fourRings(const std::string& order) {
  SensorModel sensor;
  sensor.rings = 4, sensor.columns = 3, sensor.sweep_s = 0.3, sensor.order = order;
  return sensor;
}

TEST(CompleteFromTable, GivesRingAndTimeInBothOrders) {
  Cloud cloud;
  cloud.resize(12);
  EXPECT_EQ(completeFromTable(cloud, fourRings("column_major")), "ring = k mod 4, time by column");
  EXPECT_EQ(cloud.ring, (std::vector<std::uint16_t>{0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3}));
  EXPECT_FLOAT_EQ(cloud.dt[4], 0.1F);
  Cloud rows;
  rows.resize(12);
  EXPECT_EQ(completeFromTable(rows, fourRings("row_major")), "ring = k div 3, time by column");
  EXPECT_EQ(rows.ring[5], 1);
  EXPECT_FLOAT_EQ(rows.dt[5], 0.2F);
}

TEST(CompleteFromTable, TouchesNothingThatIsThereOrNotOrganised) {
  Cloud cloud;
  cloud.resize(12);
  cloud.ring.assign(12, 7);
  EXPECT_EQ(completeFromTable(cloud, fourRings("column_major")), "time by column");
  EXPECT_EQ(cloud.ring[0], 7);
  Cloud odd;
  odd.resize(13);
  EXPECT_EQ(completeFromTable(odd, fourRings("column_major")), "");
  Cloud loose;
  loose.resize(12);
  EXPECT_EQ(completeFromTable(loose, fourRings("unorganised")), "");
  EXPECT_FALSE(loose.hasRing() || loose.hasTime());
}

Scan scanOf(std::initializer_list<Eigen::Vector3f> points) {
  Scan scan;
  for (const auto& p : points) scan.cloud.push(p.x(), p.y(), p.z());
  return scan;
}

TEST(Preprocess, DropsAndCountsWhatIsNoUse) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  Scan scan = scanOf({{5, 0, 0}, {nan, 0, 0}, {0, 0, 0}, {0, inf, 0}, {200, 0, 0}, {-1, 0, -1}, {0, 7, 0}});
  scan.T_base_sensor.translation().z() = 1;
  PreprocessParams params;
  params.self_box_m = {-2, 0.5, -1, 1, -0.5, 0.5};
  const PreprocessReport report = preprocess(scan, params);
  EXPECT_EQ(report.input, 7U);
  EXPECT_EQ(report.non_finite, 2U);
  EXPECT_EQ(report.out_of_range, 2U);
  EXPECT_EQ(report.on_robot, 1U) << "the box is in the base frame, one metre below the sensor";
  EXPECT_EQ(report.kept, 2U);
  EXPECT_EQ(scan.cloud.x, (std::vector<float>{5, 0}));
  EXPECT_FLOAT_EQ(cloudInBase(scan).z[0], 1);
}

TEST(Preprocess, CompletesRingsBeforeItDropsPoints) {
  Scan scan;
  scan.cloud.resize(12);
  for (std::size_t k = 6; k < 12; ++k) scan.cloud.x[k] = 10;
  const SensorModel table = fourRings("column_major");
  const PreprocessReport report = preprocess(scan, {}, &table);
  EXPECT_THAT(report.completed, HasSubstr("ring = k mod 4"));
  EXPECT_EQ(scan.cloud.ring, (std::vector<std::uint16_t>{2, 3, 0, 1, 2, 3}));
}

TEST(Preprocess, ABoxOfOtherThanSixNumbersIsRefused) {
  Scan scan;
  PreprocessParams params;
  params.self_box_m = {1, 2};
  EXPECT_THROW(preprocess(scan, params), Error);
}

}  // namespace
}  // namespace scslam
