// The parts of the extractors against closed forms.
#include "scslam/sensor/radar_detections.h"

#include <numeric>

#include "radar_fixtures.h"
#include "scslam/core/counter_random.h"
#include "scslam/sensor/radar_cfar.h"
#include "scslam/sensor/radar_extractor.h"

namespace scslam {
namespace {

TEST(RefinedPeak, FindsAParabolasVertexBetweenBins) {
  for (double position = 50; position < 51; position += 0.05) {
    RadarScan sweep = test::emptySweep({}, 1, 100);
    test::addEcho(sweep, 0, position, 120, 12);
    const auto row = sweep.row(0);
    const auto at = static_cast<std::size_t>(std::max_element(row.begin(), row.end()) - row.begin());
    EXPECT_NEAR(refinedPeak(row, at, 6).position, position, 0.1);
  }
}

TEST(RefinedPeak, TakesTheMiddleOfAFlatTopAndSurvivesTheEnds) {
  std::vector<std::uint8_t> row(40, 0);
  std::fill(row.begin() + 10, row.begin() + 21, 255);  // saturated: bins 10 … 20
  EXPECT_NEAR(refinedPeak(row, 10, 2).position, 15.5, 1e-6);
  EXPECT_NEAR(refinedPeak(row, 10, 9).position, 15.5, 1e-6);
  row.assign(40, 0), row[0] = 50, row[39] = 60;
  EXPECT_EQ(refinedPeak(row, 0, 5).position, 0.5F);
  EXPECT_EQ(refinedPeak(row, 39, 5).position, 39.5F);
}

TEST(FindPeaks, GivesOnePerEchoAndTheFirstBinOfATop) {
  std::vector<std::uint8_t> row(60, 0);
  const std::vector<std::uint8_t> echo = {30, 60, 80, 80, 80, 60, 62, 30};
  std::copy(echo.begin(), echo.end(), row.begin() + 10);
  row[40] = 50;
  std::vector<std::size_t> peaks;
  findPeaks(row, {0, 60, 5}, 40, peaks);
  EXPECT_EQ(peaks, (std::vector<std::size_t>{12, 40}));
  findPeaks(row, {0, 60, 1}, 40, peaks);
  EXPECT_EQ(peaks, (std::vector<std::size_t>{12, 16, 40}));
  findPeaks(row, {13, 60, 5}, 70, peaks);
  EXPECT_TRUE(peaks.empty()) << "the peak lies before what is looked at";
}

/// Share of cells of exponential noise that exceed factor * statistic of n other cells.
template <class Statistic>
double alarmRate(std::size_t n, double factor, const Statistic& statistic) {
  RandomSequence random(CounterRandom(1, RandomStream::kRadar));
  const auto power = [&random] { return -std::log(1 - random.uniform()); };
  std::size_t alarms = 0;
  constexpr std::size_t kTrials = 200'000;
  std::vector<double> cells(n);
  for (std::size_t trial = 0; trial < kTrials; ++trial) {
    for (double& cell : cells) cell = power();
    alarms += power() > factor * statistic(cells);
  }
  return static_cast<double>(alarms) / kTrials;
}

TEST(CfarFactors, GiveTheRateOfFalseAlarmsTheyPromise) {
  const auto mean = [](const std::vector<double>& cells) {
    return std::accumulate(cells.begin(), cells.end(), 0.0) / static_cast<double>(cells.size());
  };
  EXPECT_NEAR(alarmRate(16, cellAveragingFactor(0.01, 16), mean), 0.01, 0.0015);
  for (const std::size_t k : {8, 12}) {
    const auto ranked = [k](std::vector<double>& cells) {
      const auto at = cells.begin() + static_cast<std::ptrdiff_t>(k - 1);
      std::nth_element(cells.begin(), at, cells.end());
      return *at;
    };
    EXPECT_NEAR(alarmRate(16, orderedStatisticFactor(0.01, 16, k), ranked), 0.01, 0.0015) << k;
  }
}

Cloud extracted(const char* name, const RadarScan& sweep, const std::vector<std::string>& sets = {}) {
  const auto& entry = Registry<RadarExtractor>::instance().find(name);
  auto params = entry.defaults();
  for (const auto& set : sets) setParam(*params, set);
  return entry.create(*params, test::context())->extract(sweep);
}

/// Two neighbouring azimuths with a strong echo and a weak one 1.3 m behind it, in even noise.
RadarScan twoEchoes() {
  RadarScan sweep = test::emptySweep({}, 8, 1000);
  std::fill(sweep.power.begin(), sweep.power.end(), 12);
  for (const std::size_t a : {3, 4}) test::addEcho(sweep, a, 500, 120), test::addEcho(sweep, a, 530, 70);
  return sweep;
}

TEST(OrderedStatisticCfar, SeesTheWeakEchoThatTheMeanHides) {
  EXPECT_EQ(extracted("ca_cfar", twoEchoes()).size(), 2U);
  EXPECT_EQ(extracted("os_cfar", twoEchoes()).size(), 4U);
}

TEST(BoundedFalseAlarm, KeepsItsThresholdUpWhereThereIsNoNoise) {
  RadarScan sweep = test::emptySweep({}, 8, 1000);
  test::addEcho(sweep, 3, 300, 50), test::addEcho(sweep, 3, 600, 60);
  EXPECT_EQ(extracted("ca_cfar", sweep).size(), 2U);
  EXPECT_EQ(extracted("bfar", sweep).size(), 1U);
}

TEST(KStrongest, TakesBinsOrEchoes) {
  const RadarScan sweep = twoEchoes();
  EXPECT_EQ(extracted("k_strongest", sweep).size(), 4U);
  EXPECT_EQ(extracted("k_strongest", sweep, {"k=1"}).size(), 2U);
  EXPECT_EQ(extracted("k_strongest", sweep, {"peaks_only=false", "k=5"}).size(), 10U);
}

TEST(Cen2019, GrowsARegionUntilThePowerFallsBelowTheMeanAndWantsItInTheNextAzimuthToo) {
  RadarScan sweep = twoEchoes();
  for (const std::size_t a : {3, 4}) test::addEcho(sweep, a, 508, 90);  // melts into the first
  test::addEcho(sweep, 6, 200, 120);                                    // alone
  const Cloud cloud = extracted("cen2019", sweep);
  EXPECT_EQ(cloud.ring, (std::vector<std::uint16_t>{3, 3, 4, 4}));
  EXPECT_NEAR(cloud.point(0).norm(), 500 * 0.0432, 0.05);
  EXPECT_NEAR(cloud.point(1).norm(), 530 * 0.0432, 0.05);
  EXPECT_EQ(extracted("cen2019", sweep, {"max_regions=1"}).size(), 0U);
}

}  // namespace
}  // namespace scslam
