// What the filter takes from a radar's points, and what it leaves.
#include "scslam/sensor/radar_filter.h"

#include "radar_fixtures.h"
#include "scslam/sensor/radar_points.h"

namespace scslam {
namespace {

const Stamp kStart = stampFromSeconds(100);

/// A point of an azimuth at a range with a power.
void add(Cloud& cloud, const RadarScan& sweep, std::size_t azimuth, double range, double power) {
  const Eigen::Vector3f p = (range * sweep.direction(azimuth)).cast<float>();
  cloud.push(p.x(), p.y(), 0);
  cloud.intensity.push_back(static_cast<float>(power));
  cloud.dt.push_back(0);
  cloud.ring.push_back(static_cast<std::uint16_t>(azimuth));
}

std::vector<int> rangesOf(const Cloud& cloud) {
  std::vector<int> ranges;
  for (std::size_t i = 0; i < cloud.size(); ++i) ranges.push_back(static_cast<int>(std::lround(cloud.point(i).norm())));
  return ranges;
}

TEST(RadarFilter, GhostsAtMultiplesOfAStrongEchoGo) {
  const RadarScan sweep = test::emptySweep(kStart);
  Cloud cloud;
  add(cloud, sweep, 10, 8, 130);
  add(cloud, sweep, 10, 16.2, 90);  // twice
  add(cloud, sweep, 10, 20, 90);
  add(cloud, sweep, 10, 24.1, 80);  // three times
  add(cloud, sweep, 10, 40, 125);   // twice 20, but stronger
  add(cloud, sweep, 11, 16, 60);    // another azimuth
  RadarFilterParams params;
  params.speckle_neighbours = 0;
  const RadarFilterReport report = filterRadarPoints(cloud, sweep, params);
  EXPECT_EQ(report.multipath, 2U);
  EXPECT_EQ(rangesOf(cloud), (std::vector<int>{8, 20, 40, 16}));
}

TEST(RadarFilter, PointsWithoutCompanyInTheNextAzimuthsGo) {
  const RadarScan sweep = test::emptySweep(kStart);
  Cloud cloud;
  add(cloud, sweep, 0, 30, 90);  // beside azimuth 399
  add(cloud, sweep, 5, 20, 90);
  add(cloud, sweep, 5, 50, 90);  // alone
  add(cloud, sweep, 7, 20.3, 90);
  add(cloud, sweep, 9, 21, 90);  // too far in range
  add(cloud, sweep, 399, 30.2, 90);
  const RadarFilterReport report = filterRadarPoints(cloud, sweep, {});
  EXPECT_EQ(report.speckle, 2U);
  EXPECT_EQ(rangesOf(cloud), (std::vector<int>{30, 20, 20, 30}));
  RadarFilterParams off;
  off.enabled = false;
  EXPECT_EQ(filterRadarPoints(cloud, sweep, off).removed(), 0U);
}

TEST(RadarFilter, OfAStreakOnlyWhatStandsOutStays) {
  RadarScan sweep = test::emptySweep(kStart);
  std::fill(sweep.power.begin(), sweep.power.end(), 10);
  for (const std::size_t a : {100, 101}) std::fill(sweep.row(a).begin(), sweep.row(a).end(), 60);
  Cloud cloud;
  for (const std::size_t a : {100, 101, 102})
    for (const double range : {10, 20, 30}) add(cloud, sweep, a, range, range == 20 ? 120 : 75);
  const RadarFilterReport report = filterRadarPoints(cloud, sweep, {});
  EXPECT_EQ(report.raised_azimuths, 2U);
  EXPECT_EQ(report.streaks, 4U);
  EXPECT_EQ(std::count(cloud.ring.begin(), cloud.ring.end(), 100), 1);
  EXPECT_EQ(std::count(cloud.ring.begin(), cloud.ring.end(), 101), 1);
}

TEST(RadarPoints, NotesSayWhatIsWrongWithASweep) {
  const RadarPoints points({}, test::context());
  std::string note = "old";
  RadarScan sweep = test::emptySweep(kStart);
  for (std::size_t a = 0; a < sweep.azimuths; ++a) test::addEcho(sweep, a, 500, 100);
  EXPECT_EQ(points(sweep, note).size(), 400U);
  EXPECT_EQ(note, "");
  for (std::size_t a = 10; a < 20; ++a) sweep.valid[a] = 0;
  EXPECT_EQ(points(sweep, note).size(), 390U);
  EXPECT_EQ(note, "10 of 400 azimuths not measured");
  EXPECT_TRUE(points(test::emptySweep(kStart), note).empty());
  EXPECT_EQ(note, "no echo in it");
  RadarScan saturated = test::emptySweep(kStart);
  for (std::size_t i = 0; i < saturated.power.size(); ++i) saturated.power[i] = static_cast<std::uint8_t>(250 + i % 6);
  EXPECT_TRUE(points(saturated, note).empty());
  EXPECT_EQ(note, "400 azimuths with saturation streaks");
}

}  // namespace
}  // namespace scslam
