// The radar layouts: which table they take, their stamps and truths.
#include "fixtures.h"
#include "scslam/sensor/radar_points.h"
#include "scslam/sensor/sensor_tables.h"

namespace scslam {
namespace {

namespace fs = std::filesystem;
using test::fixtureStamp;
using test::fixtureSweep;
using test::writeBytes;
using testing::HasSubstr;

constexpr std::int64_t kBefore = 1606000000000000, kAfter = 1640000000000000;  // of Boreas' upgrade [us]

fs::path boreasFolder(std::int64_t first_us) {
  const fs::path folder = test::freshFolder();
  std::string poses = "GPSTime,easting,northing,altitude,vel_east,vel_north,vel_up,roll,pitch,heading,angvel_z,y,x\n";
  for (int i = 0; i < 3; ++i) {
    const std::int64_t us = first_us + 250000 * i;
    RadarScan sweep = fixtureSweep(static_cast<std::size_t>(i), stampFromNanoseconds(1000 * us - 125000000));
    std::fill(sweep.valid.begin(), sweep.valid.end(), 0);  // the byte is not used
    writeBytes(folder / "radar" / fmt::format("{}.png", us), encodeOxfordRadar(sweep));
    // Driving north at 2 m a sweep: heading pi / 2 from east, z down.
    poses += fmt::format("{},10,{},1,0,8,0,{:.12f},0,{:.12f},0,0,0\n", us, 5 + 2 * i, M_PI, M_PI / 2);
  }
  writeBytes(folder / "applanix/radar_poses.csv", poses);
  return folder;
}

TEST(Boreas, TheDateChoosesTheBinsAndTheOffsetIsApplied) {
  for (const auto& [us, resolution] : {std::pair{kBefore, 0.0596}, {kAfter, 0.04381}}) {
    const auto opened = test::openQuietly(boreasFolder(us));
    EXPECT_EQ(opened.format, "oxford_radar");
    const auto scans = test::readAll(*opened.source);
    ASSERT_EQ(scans.size(), 3U);
    EXPECT_EQ(scans[0].radar->range_resolution_m, resolution);
    EXPECT_EQ(scans[0].radar->range_offset_m, -0.31);
    EXPECT_EQ(scans[0].radar->valid[0], 255) << "its byte 10 says nothing";
    EXPECT_NEAR(secondsBetween(scans[0].stamp, stampFromNanoseconds(1000 * us)), 0.125, 1e-6);
  }
}

TEST(Boreas, TruthLooksWhereTheCarDrives) {
  const auto truth = test::openQuietly(boreasFolder(kBefore)).source->groundTruth();
  ASSERT_TRUE(truth);
  ASSERT_EQ(truth->poses.size(), 3U);
  const Pose T = truth->poses[0].T.inverse() * truth->poses[1].T;
  EXPECT_THAT(T, test::IsNear(poseFromYaw(0, {2, 0, 0}), 1e-6, 1e-4));
  EXPECT_THAT(truth->poses[0].T, test::IsNear(poseFromYaw(M_PI / 2, {10, 5, 1}), 1e-6, 1e-4));
}

TEST(Mulran, RadarAndLidarOfOneRecordingAreChosenByTheOption) {
  const fs::path folder = test::freshFolder();
  test::makeFixture("mulran_radar", folder);
  writeBytes(folder / "sensor_data/Ouster/1561000444000000000.bin", test::encodeXyzi(test::fixtureCloud(0)));
  EXPECT_EQ(test::openQuietly(folder).format, "mulran");
  OpenOptions options;
  options.radar = true;
  EXPECT_EQ(test::openQuietly(folder, options).format, "mulran_radar");
  EXPECT_EQ(test::openQuietly(folder / "sensor_data/radar/polar_oxford_form").format, "mulran_radar");
  EXPECT_TRUE(test::openQuietly(folder / "sensor_data/radar/polar_oxford_form").source->groundTruth());
}

TEST(Mulran, TheStampOfAPictureIsTheEndOfItsSweep) {
  const fs::path folder = test::freshFolder();
  const RadarScan sweep = fixtureSweep(0, fixtureStamp(0));
  const std::int64_t end = 1561000444000000000 + 218'750'000;  // the eighth of 8 azimuths, 31.25 ms each
  writeBytes(folder / "radar/polar" / fmt::format("{}.png", end), test::encodeColumns(sweep));
  auto source = test::openQuietly(folder).source;
  EXPECT_THAT(source->description(), HasSubstr("0.0595238 m"));
  const Scan scan = *source->next();
  EXPECT_EQ(scan.radar->power, sweep.power);
  EXPECT_EQ(scan.radar->stamps, sweep.stamps);
  EXPECT_NEAR(scan.T_base_sensor.translation().x(), 1.5, 1e-12);
}

TEST(Mulran, NanosecondsAndOneStampForAllRowsAreUnderstood) {
  const fs::path folder = test::freshFolder();
  RadarScan sweep = fixtureSweep(0, fixtureStamp(0));
  // encodeOxfordRadar writes microseconds: a stamp a thousand times as far from 1970 writes nanoseconds.
  const std::int64_t end = 1561000444000000000 + 218'750'000;
  GreyImage image = decodeGreyPng(encodeOxfordRadar(sweep), "");
  for (std::size_t row = 0; row < image.rows; ++row)
    std::memcpy(image.pixels.data() + row * image.columns, &end, sizeof end);
  writeBytes(folder / "polar_oxford_form" / fmt::format("{}.png", end), encodeGreyPng(image, false));
  const Scan scan = *test::openQuietly(folder).source->next();
  EXPECT_EQ(scan.stamp, fixtureStamp(0));
  EXPECT_EQ(scan.radar->stamps, sweep.stamps);
}

TEST(Radiate, PicturesWithoutATimeAreLeftOutAndRowsMayBeAzimuths) {
  const auto fixture = test::makeFixture("radiate", test::freshFolder());
  test::writeBytes(fixture.uri / "Navtech_Polar/000099.png", test::readBytes(fixture.damage));
  const auto source = test::openQuietly(fixture.uri).source;
  EXPECT_THAT(source->description(), HasSubstr("1 images without a time left out"));
  EXPECT_EQ(test::readAll(*source).size(), test::kFixtureScans);
  test::writeBytes(fixture.uri / "Navtech_Polar.txt", "Frame: 1 Time: soon\n");
  EXPECT_THAT(test::messageOf([&] { test::openQuietly(fixture.uri); }), HasSubstr("Navtech_Polar.txt:1: not 'Frame:"));

  SensorModel table = loadSensorModel("navtech_radiate");
  const fs::path folder = test::freshFolder();
  const RadarScan sweep = fixtureSweep(0, fixtureStamp(0));
  table.columns = static_cast<int>(sweep.azimuths);
  GreyImage image{sweep.azimuths, sweep.bins, sweep.power};
  writeBytes(folder / "Navtech_Polar/000001.png", encodeGreyPng(image, true));
  OpenOptions options;
  options.sensor = table;
  EXPECT_EQ(test::openQuietly(folder, options).source->next()->radar->power, sweep.power);
}

TEST(OxfordRadarFolder, ATruthThatDoesNotJoinOnEndsThere) {
  const auto fixture = test::makeFixture("oxford_radar", test::freshFolder());
  const fs::path file = fixture.uri / "gt/radar_odometry.csv";
  writeBytes(file, test::readBytes(file) + "1561009999000000,1561009998000000,1,0,0,0,0,0\n");
  const auto source = test::openQuietly(fixture.uri).source;
  EXPECT_THAT(source->description(), HasSubstr("up to line 7, where it breaks off"));
  EXPECT_EQ(source->groundTruth()->poses.size(), test::kFixtureScans);
  EXPECT_THAT(source->description(), HasSubstr("bins of 0.0438 m and offset 0 m assumed"));
}

TEST(OxfordRadarFolder, ATableOfTheUserReplacesTheAssumedOne) {
  const auto fixture = test::makeFixture("oxford_radar", test::freshFolder());
  OpenOptions options;
  options.sensor = loadSensorModel("navtech_cts350x");
  options.sensor->radar.range_resolution_m = 0.0432;
  EXPECT_EQ(test::openQuietly(fixture.uri, options).source->next()->radar->range_resolution_m, 0.0432);
}

TEST(OxfordRadarFolder, RealSweepsAreReadWithTheirTruth) {
  SCSLAM_NEEDS_DATA(folder, "oxford_radar_tiny");
  const auto opened = test::openQuietly(folder);
  EXPECT_EQ(opened.format, "oxford_radar");
  const auto scans = test::readAll(*opened.source);
  ASSERT_EQ(scans.size(), 11U);
  const auto truth = opened.source->groundTruth();
  ASSERT_TRUE(truth);
  double path = 0;
  for (std::size_t i = 1; i < truth->poses.size(); ++i)
    path += (truth->poses[i].T.translation() - truth->poses[i - 1].T.translation()).norm();
  EXPECT_NEAR(path, 3080, 10);
  const RadarPoints points({}, test::context());
  for (const Scan& scan : scans) {
    EXPECT_TRUE(truth->at(scan.stamp));
    std::string note;
    const Cloud cloud = points(*scan.radar, note);
    EXPECT_EQ(note, "");
    EXPECT_GT(cloud.size(), 1000U);
    EXPECT_LT(cloud.size(), 4800U);
  }
}

}  // namespace
}  // namespace scslam
