// Speckle, noise and saturation.
#include "sim/radar_receiver.h"

#include "radar_fixtures.h"
#include "sim/radar_statistics.h"

namespace scslam::sim {
namespace {

using namespace test;

struct Moments {
  double n = 0, mean = 0, sigma = 0;
  explicit Moments(const std::vector<double>& values) : n(static_cast<double>(values.size())) {
    for (const double v : values) mean += v / n;
    for (const double v : values) sigma += (v - mean) * (v - mean) / (n - 1);
    sigma = std::sqrt(sigma);
  }
  /// mean / sigma of n exponential numbers has the standard deviation 1 / sqrt(n).
  void expectExponential() const { EXPECT_NEAR(sigma / mean, 1, 3 / std::sqrt(n)) << n << " values"; }
};

World emptyWorld() {
  MeshBuilder b;
  b.material("black").box({0, 0, -900}, 1, 1, 1);
  return worldOf(b);
}

TEST(RadarReceiver, SpeckleIsExponentialInACell) {
  RadarModel model = bare();
  model.speckle = true, model.rays_per_azimuth = 64;
  MeshBuilder b;
  b.material("leaves").cylinder({0, 0, -20}, {0, 0, 20}, 20, 400);
  const World world = worldOf(b);
  std::vector<double> values;
  for (std::uint32_t number = 0; number < 12; ++number) {
    const RadarScan scan = scanOf(model, world, straight(), 0, 5, number);
    for (std::size_t row = 0; row < 400; row += 5)  // beyond the beam's width: independent
      values.push_back(powerOf(scan.row(row)[static_cast<std::size_t>(20 / 0.0438)]));
  }
  Moments(values).expectExponential();
}

TEST(RadarReceiver, SpeckleKeepsTheMeanPower) {
  RadarModel model = bare();
  model.rays_per_azimuth = 64;
  MeshBuilder b;
  b.material("leaves").cylinder({0, 0, -20}, {0, 0, 20}, 20, 400);
  const World world = worldOf(b);
  const auto bin = static_cast<std::size_t>(20 / 0.0438);
  const auto meanOver = [&](const RadarScan& scan) {
    double sum = 0;
    for (std::size_t row = 0; row < 400; ++row) sum += powerOf(scan.row(row)[bin]) / 400;
    return sum;
  };
  const double flat = meanOver(scanOf(model, world));
  model.speckle = true;
  double mean = 0;
  for (std::uint32_t number = 0; number < 10; ++number)
    mean += meanOver(scanOf(model, world, straight(), 0, 5, number)) / 10;
  EXPECT_NEAR(mean / flat, 1, 0.12);
}

TEST(RadarReceiver, NoiseIsExponentialWithItsMeanAndIndependentAcrossRows) {
  RadarModel model = shipped();
  model.noise = 1000;
  const RadarScan scan = scanOf(model, emptyWorld());
  std::vector<double> values;
  for (std::size_t row = 0; row < 400; ++row)
    for (std::size_t bin = 0; bin < scan.bins; bin += 40) values.push_back(powerOf(scan.row(row)[bin]));
  const Moments m(values);
  m.expectExponential();
  EXPECT_NEAR(m.mean, 1000, 3 * 1000 / std::sqrt(m.n));
  const RadarStatistics s = statisticsOf(scan);
  EXPECT_NEAR(s.azimuth_correlation, 0, 0.02);
  EXPECT_GT(s.range_correlation[0], 0.9);
}

TEST(RadarReceiver, StrongReturnsSaturateAndRaiseTheNoiseBehindThem) {
  RadarModel model = shipped();
  model.translation_m = {0, 0, 0};
  model.saturation_db = 40, model.streak_db = 20, model.phase_noise_db = -200, model.max_bounces = 1;
  MeshBuilder b;
  boxAt(b, 60, M_PI / 2, 3);
  const RadarScan scan = scanOf(model, worldOf(b));
  const auto row = scan.row(100), other = scan.row(300);
  const auto mean = [](std::span<const std::uint8_t> levels) {
    double sum = 0;
    for (const auto level : levels) sum += powerOf(level);
    return sum / static_cast<double>(levels.size());
  };
  EXPECT_EQ(*std::max_element(row.begin(), row.end()), 80);  // half decibels
  EXPECT_LT(mean(row.first(1200)), 2.5);
  EXPECT_GT(mean(row.subspan(1600)), 100 * mean(other.subspan(1600)));
}

TEST(RadarReceiver, SquareRootCompressionReachesWhiteAtSaturation) {
  RadarModel model = bare();
  model.compression = "sqrt", model.saturation_db = 40;
  MeshBuilder b;
  boxAt(b, 20, 0, 3);
  const RadarScan scan = scanOf(model, worldOf(b));
  EXPECT_EQ(*std::max_element(scan.power.begin(), scan.power.end()), 255);
}

}  // namespace
}  // namespace scslam::sim
