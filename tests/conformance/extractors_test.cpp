// What every radar extractor must keep, run on each that is registered.
#include <cmath>
#include <map>

#include "scslam/sensor/radar_extractor.h"
#include "sensor/radar_fixtures.h"
#include "sim/radar_fixtures.h"

namespace scslam {
namespace {

using Eigen::Vector3d;

class EveryExtractor : public testing::TestWithParam<std::string> {
 protected:
  static std::unique_ptr<RadarExtractor> make(int threads = 1) {
    return Registry<RadarExtractor>::instance().create(GetParam(), test::context(threads));
  }
};

/// Three plates at right angles, open towards the origin: the apex is `range` away, `azimuth` clockwise.
void reflectorAt(sim::MeshBuilder& builder, double range, double azimuth) {
  const Vector3d direction(std::cos(azimuth), -std::sin(azimuth), 0);
  const Eigen::Matrix3d R = Eigen::Quaterniond::FromTwoVectors(Vector3d(1, 1, 1), -direction).toRotationMatrix();
  const auto at = [&](double x, double y, double z) {
    return Vector3d(range * direction + 0.4 * (R * Vector3d(x, y, z)));
  };
  builder.material("retro_reflector");
  builder.quad(at(0, 0, 0), at(1, 0, 0), at(1, 1, 0), at(0, 1, 0));
  builder.quad(at(0, 0, 0), at(0, 1, 0), at(0, 1, 1), at(0, 0, 1));
  builder.quad(at(0, 0, 0), at(0, 0, 1), at(1, 0, 1), at(1, 0, 0));
}

/// The mean of the directions of the points within a metre of `range`, by power; and the strongest one's range.
struct Found {
  double range = 0, azimuth = 0;
};
Found near(const Cloud& cloud, double range) {
  Vector3d sum = Vector3d::Zero();
  double strongest = 0;
  Found found;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vector3d p = cloud.point(i).cast<double>();
    if (std::abs(p.norm() - range) > 1) continue;
    const double power = std::pow(10, static_cast<double>(cloud.intensity[i]) / 20);
    sum += power * p.normalized();
    if (power > strongest) strongest = power, found.range = p.norm();
  }
  found.azimuth = std::atan2(-sum.y(), sum.x());
  return found;
}

struct Reflector {
  const char* radar;
  double range, azimuth;  ///< clockwise
  RadarScan scan;
};

/// Simulated once for all extractors.
const std::vector<Reflector>& reflectors() {
  static const std::vector<Reflector> all = [] {
    std::vector<Reflector> made;
    for (const auto& [name, range, degrees] :
         {std::tuple{"cts350-x", 25.02, 0.0}, {"cts350-x", 41.37, 123.4}, {"cir204-h", 33.3, 271.75}}) {
      sim::RadarModel model = sim::test::shipped(name);
      model.translation_m = {0, 0, 0}, model.rpy_deg = {0, 0, 0};
      model.surface_slope_deg = 3;
      sim::MeshBuilder builder;
      const double azimuth = degrees * M_PI / 180;
      reflectorAt(builder, range, azimuth);
      made.push_back({name, range, azimuth, sim::test::scanOf(model, sim::test::worldOf(builder))});
    }
    return made;
  }();
  return all;
}

TEST_P(EveryExtractor, CornerReflectorIsAtItsRangeAndAzimuthToAQuarterOfABin) {
  for (const Reflector& reflector : reflectors()) {
    const Found found = near(make()->extract(reflector.scan), reflector.range);
    EXPECT_NEAR(found.range, reflector.range, 0.25 * reflector.scan.range_resolution_m) << reflector.radar;
    const double step = 2 * M_PI / static_cast<double>(reflector.scan.azimuths);
    EXPECT_NEAR(std::remainder(found.azimuth - reflector.azimuth, 2 * M_PI), 0, 0.25 * step) << reflector.radar;
  }
}

/// A street as an image; the same for all tests.
const RadarScan& street() {
  static const RadarScan scan = sim::test::scanOf(sim::test::shipped(), sim::test::aStreet());
  return scan;
}

TEST_P(EveryExtractor, PointsAreOrderedAndCarryAllFields) {
  const RadarScan& scan = street();
  const Cloud cloud = make()->extract(scan);
  EXPECT_GT(cloud.size(), 400U);
  EXPECT_LT(cloud.size(), 40'000U);
  ASSERT_EQ(cloud.intensity.size(), cloud.size());
  ASSERT_EQ(cloud.dt.size(), cloud.size());
  ASSERT_EQ(cloud.ring.size(), cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const std::size_t azimuth = cloud.ring[i];
    ASSERT_LT(azimuth, scan.azimuths);
    EXPECT_EQ(cloud.z[i], 0);
    EXPECT_GT(cloud.intensity[i], 0);
    EXPECT_LE(cloud.intensity[i], 255);
    EXPECT_NEAR(cloud.dt[i], secondsBetween(scan.stamps.front(), scan.stamps[azimuth]), 1e-6);
    const Vector3d p = cloud.point(i).cast<double>();
    EXPECT_NEAR((p.normalized() - scan.direction(azimuth)).norm(), 0, 1e-5);
    const double bin = (p.norm() - scan.range_offset_m) / scan.range_resolution_m - 0.5;
    EXPECT_NEAR(cloud.intensity[i], scan.row(azimuth)[static_cast<std::size_t>(std::lround(bin))], 25) << "at " << bin;
    if (i == 0) continue;
    ASSERT_GE(azimuth, cloud.ring[i - 1]);
    if (azimuth == cloud.ring[i - 1]) {
      EXPECT_GT(p.norm(), cloud.point(i - 1).norm());
    }
  }
}

TEST_P(EveryExtractor, MostPointsLieOnWhatStandsInTheStreet) {
  const Cloud cloud = make()->extract(street());
  const std::size_t near_walls =
      static_cast<std::size_t>(std::count_if(cloud.y.begin(), cloud.y.end(), [](float y) { return std::abs(y) < 30; }));
  EXPECT_GT(near_walls, cloud.size() / 2);
}

TEST_P(EveryExtractor, IsTheSameForAnyNumberOfThreads) {
  const Cloud one = make(1)->extract(street()), three = make(3)->extract(street());
  EXPECT_EQ(one.x, three.x);
  EXPECT_EQ(one.y, three.y);
  EXPECT_EQ(one.intensity, three.intensity);
}

TEST_P(EveryExtractor, ATurnedImageGivesTurnedPoints) {
  RadarScan turned = street();
  const std::size_t shift = 100;  // a quarter
  for (std::size_t i = 0; i < turned.azimuths; ++i) {
    const auto from = street().row((i + shift) % turned.azimuths);
    std::copy(from.begin(), from.end(), turned.row(i).begin());
  }
  const Cloud a = make()->extract(street()), b = make()->extract(turned);
  EXPECT_NEAR(static_cast<double>(a.size()), static_cast<double>(b.size()), 0.01 * static_cast<double>(a.size()));
  std::map<std::pair<std::size_t, long>, float> points;  // by azimuth and range
  const auto keyOf = [](const Cloud& cloud, std::size_t i, std::size_t azimuth) {
    return std::pair{azimuth, std::lround(cloud.point(i).norm() * 1e3F)};
  };
  for (std::size_t i = 0; i < a.size(); ++i) points[keyOf(a, i, a.ring[i])] = a.intensity[i];
  std::size_t missing = 0;
  for (std::size_t i = 0; i < b.size(); ++i) missing += !points.contains(keyOf(b, i, (b.ring[i] + shift) % 400));
  EXPECT_LE(missing, b.size() / 100) << "a millimetre may round the other way";
}

TEST_P(EveryExtractor, AzimuthsThatWereNotMeasuredGiveNothing) {
  RadarScan scan = street();
  for (std::size_t i = 50; i < 150; ++i) scan.valid[i] = 0;
  const Cloud cloud = make()->extract(scan);
  EXPECT_FALSE(cloud.empty());
  for (const std::uint16_t azimuth : cloud.ring) EXPECT_TRUE(azimuth < 50 || azimuth >= 150) << azimuth;
}

TEST_P(EveryExtractor, WithoutEchoesThereAreNoPoints) {
  EXPECT_TRUE(make()->extract(test::emptySweep({})).empty());
  RadarScan flat = test::emptySweep({});
  std::fill(flat.power.begin(), flat.power.end(), 20);
  EXPECT_TRUE(make()->extract(flat).empty());
}

TEST_P(EveryExtractor, OddImagesAreSurvived) {
  const auto extractor = make();
  EXPECT_TRUE(extractor->extract({}).empty());
  for (const auto& [azimuths, bins] : {std::pair<std::size_t, std::size_t>{1, 1}, {1, 2}, {2, 3}, {3, 64}, {5, 1000}}) {
    RadarScan scan = test::emptySweep({}, azimuths, bins);
    for (std::size_t i = 0; i < scan.power.size(); ++i) scan.power[i] = static_cast<std::uint8_t>(i * i * 37);
    extractor->extract(scan);
    std::fill(scan.power.begin(), scan.power.end(), 255);
    EXPECT_LE(extractor->extract(scan).size(), azimuths * 2) << "a saturated image has no peaks";
    for (const double resolution : {0.0, -1.0, 1e-12, 1e12, std::nan("")}) {
      scan.range_resolution_m = resolution;
      const Cloud cloud = extractor->extract(scan);
      for (std::size_t i = 0; i < cloud.size(); ++i) EXPECT_TRUE(cloud.point(i).allFinite());
    }
    scan = test::emptySweep({}, azimuths, bins);
    scan.range_offset_m = -1e6;
    extractor->extract(scan);
    scan.angles.front() = std::nan("");
    scan.valid.pop_back();  // no longer consistent
    EXPECT_TRUE(extractor->extract(scan).empty());
  }
}

std::string nameOf(const testing::TestParamInfo<std::string>& info) { return info.param; }
INSTANTIATE_TEST_SUITE_P(RadarExtractors, EveryExtractor,
                         testing::ValuesIn(Registry<RadarExtractor>::instance().names()), nameOf);

}  // namespace
}  // namespace scslam
