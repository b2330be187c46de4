// The figures of an image, and those of a simulated street beside a real one.
#include "sim/radar_statistics.h"

#include "radar_fixtures.h"
#include "scslam/sensor/oxford_radar.h"

namespace scslam::sim {
namespace {

using namespace test;

TEST(RadarStatistics, FiguresOfAnImageMadeForIt) {
  RadarScan scan;
  scan.resize(4, 80);
  for (std::size_t row = 0; row < 4; ++row)
    for (std::size_t bin = 0; bin < 80; ++bin) scan.row(row)[bin] = bin % 2 == 0 ? 0 : 10;
  scan.row(0)[5] = 255;
  const RadarStatistics s = statisticsOf(scan);
  EXPECT_DOUBLE_EQ(s.zeros, 0.5);
  EXPECT_DOUBLE_EQ(s.quiet_mean, 5);
  EXPECT_DOUBLE_EQ(s.quiet_sigma, 5);
  EXPECT_DOUBLE_EQ(s.quiet_p99, 10);
  EXPECT_NEAR(s.quiet_range_correlation[0], -1, 1e-12);
  EXPECT_NEAR(s.quiet_range_correlation[1], 1, 1e-12);
  EXPECT_NEAR(s.quiet_azimuth_correlation, 1, 1e-12);
  EXPECT_DOUBLE_EQ(s.strong, 0.25);
  EXPECT_DOUBLE_EQ(s.saturated, 1.0 / 320);
  EXPECT_DOUBLE_EQ(s.percentiles[3], 0);
  EXPECT_DOUBLE_EQ(s.profile[7], 5);
}

TEST(RadarStatistics, EmptyOrInvalidImagesGiveZeros) {
  EXPECT_EQ(statisticsOf({}).quiet_mean, 0);
  RadarScan scan;
  scan.resize(3, 10);
  scan.valid.assign(3, 0);
  scan.power.assign(30, 9);
  EXPECT_EQ(statisticsOf(scan).quiet_mean, 0);
}

/// Bands around the eleven images of the Oxford sample (mean of them in brackets).
TEST(RadarStatistics, SimulatedStreetLooksLikeARealOne) {
  const RadarScan scan = scanOf(shipped(), aStreet(), straight(0));
  const RadarStatistics s = statisticsOf(scan);
  EXPECT_NEAR(s.zeros, 0.34, 0.2);
  EXPECT_NEAR(s.quiet_mean, 6.8, 3);
  EXPECT_NEAR(s.quiet_sigma, 9.4, 4);
  EXPECT_NEAR(s.azimuth_correlation, 0.745, 0.1);
  EXPECT_NEAR(s.range_correlation[0], 0.986, 0.01);
  EXPECT_NEAR(s.range_correlation[2], 0.89, 0.05);
  EXPECT_GT(s.strong, 10);
  EXPECT_NEAR(s.percentiles[3], 7, 6);
  EXPECT_NEAR(s.percentiles[5], 45, 20);
  EXPECT_NEAR(s.percentiles[6], 75, 20);
  EXPECT_EQ(s.saturated, 0);
}

TEST(RadarStatistics, BesideRealImages) {
  SCSLAM_NEEDS_DATA(folder, "oxford_radar_tiny/radar");
  const auto real = statisticsOf(readOxfordRadar(folder / "1547131046353776.png"));
  const auto simulated = statisticsOf(scanOf(shipped(), aStreet()));
  const std::string table = compareStatistics("real", real, "simulated", simulated);
  std::cout << table;
  EXPECT_NEAR(real.quiet_mean, 6.1, 0.1);
  EXPECT_THAT(table, testing::HasSubstr("share of exact zeros"));
  EXPECT_LT(std::abs(real.zeros - simulated.zeros), 0.2);
  EXPECT_LT(std::abs(real.azimuth_correlation - simulated.azimuth_correlation), 0.1);
}

}  // namespace
}  // namespace scslam::sim
