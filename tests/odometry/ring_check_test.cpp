// A sensor table of another sensor: one clear line from the methods that work along rings.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "odometry/spinning.h"
#include "scslam/odometry/odometry.h"

namespace scslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class Rings : public ::testing::TestWithParam<std::string> {
 protected:
  static std::string lineFor(const Scan& scan, const std::vector<std::string>& settings = {}) {
    const auto& entry = Registry<Odometry>::instance().find(GetParam());
    const auto params = entry.defaults();
    for (const auto& setting : settings) setParam(*params, setting);
    try {
      const OdometryStep step = entry.create(*params, test::context())->step(scan);
      return step.quality.ok ? "" : step.quality.note;
    } catch (const Error& error) {
      return error.what();
    }
  }
};

/// Rings as a table of `rings` lasers gives them to points that come column by column.
Scan numberedModulo(std::size_t rings) {
  Scan scan = test::spunAt(0, Pose::Identity());
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) scan.cloud.ring[i] = static_cast<std::uint16_t>(i % rings);
  return scan;
}

std::string elevations(int rings, double low_rad, double high_rad) {
  std::string text = "rings.elevation_deg=[";
  for (int r = 0; r < rings; ++r)
    text += fmt::format("{}{:.4f}", r ? "," : "", (low_rad + (high_rad - low_rad) * r / (rings - 1)) * 180 / M_PI);
  return text + "]";
}

TEST_P(Rings, OfTheSensorAreTaken) {
  EXPECT_EQ(lineFor(numberedModulo(32)), "");
  Scan bare = test::spunAt(0, Pose::Identity());
  bare.cloud.ring.clear();
  EXPECT_EQ(lineFor(bare, {elevations(32, -0.5, 0.3)}), "");
  EXPECT_EQ(lineFor(bare, {elevations(48, -0.5, 0.3 + 16 * 0.8 / 31)}), "") << "beams into the sky return nothing";
}

TEST_P(Rings, OfATableWithFewerLasersAreOneClearLine) {
  EXPECT_THAT(lineFor(numberedModulo(16)), AllOf(HasSubstr("another number of rings"), HasSubstr("wrong sensor table"),
                                                 HasSubstr("--odometry voxel_icp")));
}

TEST_P(Rings, OfATableWithMoreLasersAreOneClearLine) {
  EXPECT_THAT(lineFor(numberedModulo(64)), AllOf(HasSubstr("fewer rings"), HasSubstr("wrong sensor table")));
}

TEST_P(Rings, GivenBeamsOfAnotherSensorAreOneClearLine) {
  Scan bare = test::spunAt(0, Pose::Identity());
  bare.cloud.ring.clear();
  EXPECT_THAT(lineFor(bare, {elevations(16, -0.26, 0.26)}), HasSubstr("do not lie on the 16 elevations"));
  EXPECT_THAT(lineFor(bare, {elevations(63, -0.5, 0.3)}), HasSubstr("of the 63 elevations that were given only 32"));
}

INSTANTIATE_TEST_SUITE_P(FrontEnds, Rings, ::testing::Values("loam", "lego"),
                         [](const auto& tested) { return tested.param; });

}  // namespace
}  // namespace scslam
