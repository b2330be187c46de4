// What is mended in a sweep, and what is not believed.
#include "scslam/sensor/radar_sweep.h"

#include "radar_fixtures.h"
#include "scslam/sensor/radar_observation.h"
#include "scslam/sensor/rawlog_scans.h"

namespace scslam {
namespace {

const Stamp kStart = stampFromNanoseconds(1547131046000000000);

std::size_t countInvalid(const RadarScan& sweep) {
  return static_cast<std::size_t>(std::count(sweep.valid.begin(), sweep.valid.end(), 0));
}

void expectEven(const RadarScan& sweep, const RadarScan& whole) {
  for (std::size_t i = 0; i < sweep.azimuths; ++i) {
    EXPECT_NEAR(secondsBetween(whole.stamps[i], sweep.stamps[i]), 0, 1e-6) << i;
    EXPECT_NEAR(std::remainder(sweep.angles[i] - whole.angles[i], 2 * M_PI), 0, 1e-9) << i;
  }
}

TEST(RadarSweep, AWholeOneIsLeftAlone) {
  RadarScan sweep = test::emptySweep(kStart);
  const RadarScan before = sweep;
  EXPECT_EQ(mendSweep(sweep), 0U);
  evenStamps(sweep);
  EXPECT_EQ(sweep.valid, before.valid);
  EXPECT_EQ(sweep.angles, before.angles);
  EXPECT_EQ(sweep.stamps, before.stamps);
}

TEST(RadarSweep, DroppedAzimuthsGetStampsAndAnglesBetweenTheirNeighbours) {
  const RadarScan whole = test::emptySweep(kStart);
  RadarScan sweep = whole;
  for (const std::size_t i : {0, 1, 7, 100, 101, 102, 103, 398, 399})
    sweep.valid[i] = 0, sweep.stamps[i] = Stamp{}, sweep.angles[i] = 0;
  EXPECT_EQ(mendSweep(sweep), 9U);
  expectEven(sweep, whole);
}

TEST(RadarSweep, AStandingEncoderInvalidatesTheAzimuthsItSpoils) {
  const RadarScan whole = test::emptySweep(kStart);
  RadarScan sweep = whole;
  for (std::size_t i = 200; i < 260; ++i) sweep.angles[i] = sweep.angles[199];
  EXPECT_EQ(mendSweep(sweep), 60U);
  for (std::size_t i = 0; i < sweep.azimuths; ++i) EXPECT_EQ(sweep.valid[i] == 0, i >= 200 && i < 260) << i;
  expectEven(sweep, whole);

  sweep = whole;
  std::fill(sweep.angles.begin(), sweep.angles.end(), 1.0);
  EXPECT_EQ(mendSweep(sweep), 400U) << "no azimuth of it can be believed";
  EXPECT_EQ(countInvalid(sweep), 400U);
}

TEST(RadarSweep, OneStampThatJumpsDoesNotSpoilTheRest) {
  const RadarScan whole = test::emptySweep(kStart);
  RadarScan sweep = whole;
  sweep.stamps[50] += std::chrono::hours(2);
  sweep.stamps[60] -= std::chrono::hours(2);
  sweep.angles[70] = std::nan("");
  EXPECT_EQ(mendSweep(sweep), 3U);
  expectEven(sweep, whole);
}

TEST(RadarSweep, StampsOfPacketsAreEvened) {
  const RadarScan whole = test::emptySweep(kStart);
  RadarScan sweep = whole;
  for (std::size_t i = 0; i < sweep.azimuths; ++i)
    sweep.stamps[i] = whole.stamps[std::min<std::size_t>(399, i / 13 * 13 + 12)];
  evenStamps(sweep);
  const double lag = secondsBetween(whole.stamps[0], sweep.stamps[0]);
  EXPECT_GT(lag, 0.003);  // half a packet
  EXPECT_LT(lag, 0.005);
  for (std::size_t i = 0; i < sweep.azimuths; ++i)
    EXPECT_NEAR(secondsBetween(whole.stamps[i], sweep.stamps[i]), lag, 5e-4) << i;

  sweep = whole;
  for (std::size_t i = 200; i < 400; ++i) sweep.stamps[i] += std::chrono::milliseconds(300);  // the antenna stood
  const auto before = sweep.stamps;
  evenStamps(sweep);
  EXPECT_EQ(sweep.stamps, before);
}

TEST(RadarSweep, BecomesAPlanarScan) {
  RadarScan sweep = test::emptySweep(kStart, 20, 30);
  sweep.T_base_sensor = poseFromYaw(0.3, {1, 2, 3});
  const Scan scan = scanOfSweep(sweep);
  EXPECT_EQ(scan.stamp, kStart);
  EXPECT_TRUE(scan.planar);
  EXPECT_TRUE(scan.cloud.empty());
  ASSERT_TRUE(scan.radar);
  EXPECT_EQ(scan.radar->bins, 30U);
  EXPECT_EQ(scan.T_base_sensor.matrix(), sweep.T_base_sensor.matrix());
  EXPECT_EQ(scanOfSweep({}).radar->azimuths, 0U);
}

TEST(RadarSweep, ATableReplacesResolutionAndOffsetOfARecordedOne) {
  CObservationRadar observation(test::emptySweep(kStart, 20, 30));
  const Scan as_recorded = scanFrom(observation, std::nullopt, "a.rawlog");
  EXPECT_EQ(as_recorded.radar->range_resolution_m, 0.0432);
  SensorModel table;
  EXPECT_EQ(scanFrom(observation, table, "a.rawlog").radar->range_resolution_m, 0.0432);
  table.radar.range_resolution_m = 0.0596, table.radar.range_offset_m = -0.31, table.radar.doppler_beta_s = 0.049;
  const Scan other = scanFrom(observation, table, "a.rawlog");
  EXPECT_EQ(other.radar->range_resolution_m, 0.0596);
  EXPECT_EQ(other.radar->range_offset_m, -0.31);
  EXPECT_EQ(other.radar->doppler_beta_s, 0.049);
}

}  // namespace
}  // namespace scslam
