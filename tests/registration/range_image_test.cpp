#include "scslam/registration/range_image.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

namespace scslam {
namespace {

/// A cylinder of radius r around the z axis, a point per degree; heights -h .. h every 0.1 m.
Cloud cylinder(float r, float h, int from_deg = 0, int to_deg = 360) {
  Cloud cloud;
  for (int a = from_deg; a < to_deg; ++a)
    for (float z = -h; z <= h; z += 0.1f) {
      const float angle = static_cast<float>(a) * static_cast<float>(M_PI / 180);
      cloud.push(r * std::cos(angle), r * std::sin(angle), z);
    }
  return cloud;
}

TEST(RangeImage, TellsFreeSurfaceAndBehindAlongARay) {
  const RangeImage image(cylinder(10, 2), Eigen::Vector3f::Zero(), false);
  EXPECT_EQ(image.at({5, 1, 0}, 0.5f), Sight::kFree);
  EXPECT_EQ(image.at({9.8f, 1, 0}, 0.5f), Sight::kSurface);
  EXPECT_EQ(image.at({10.3f, 1, 0}, 0.5f), Sight::kSurface);
  EXPECT_EQ(image.at({-14, 2, 0}, 0.5f), Sight::kBehind);
  EXPECT_EQ(image.at({1, 1, 12}, 0.5f), Sight::kUnknown) << "no return from above";
  EXPECT_EQ(image.at({0, 0, 0}, 0.5f), Sight::kUnknown) << "the sensor's own place";
}

TEST(RangeImage, LooksFromTheViewpoint) {
  const Eigen::Vector3f viewpoint(0, 0, 1.5f);
  const RangeImage image(cylinder(10, 2), viewpoint, false);
  EXPECT_EQ(image.viewpoint(), viewpoint);
  EXPECT_EQ(image.at({5, 0, 1.5f}, 0.5f), Sight::kFree);
  EXPECT_EQ(image.at({5, 0, 2.5f}, 0.5f), Sight::kUnknown) << "above the wall's upper edge as seen from there";
}

TEST(RangeImage, IsNotSureBesideAnEdge) {
  // A near pole before a far wall: directions next to the pole are not clearly free.
  Cloud cloud = cylinder(20, 2);
  for (float z = -1; z < 1; z += 0.1f) cloud.push(5, 0, z);
  const RangeImage image(cloud, Eigen::Vector3f::Zero(), false);
  EXPECT_EQ(image.at({10, 0.2f, 0}, 0.5f), Sight::kSurface);
  EXPECT_EQ(image.at({10, 3, 0}, 0.5f), Sight::kFree) << "17 degrees away it is";
}

TEST(RangeImage, WrapsAroundBehindTheSensor) {
  const RangeImage image(cylinder(10, 1, 90, 180), Eigen::Vector3f::Zero(), false);
  EXPECT_EQ(image.at({-5, 0.05f, 0}, 0.5f), Sight::kFree);
  EXPECT_EQ(image.at({-5, -1, 0}, 0.5f), Sight::kUnknown);
}

TEST(RangeImage, PlanarDataIgnoresHeights) {
  const RangeImage image(cylinder(10, 0), Eigen::Vector3f::Zero(), true);
  EXPECT_EQ(image.at({5, 0, 3}, 0.5f), Sight::kFree);
  EXPECT_EQ(image.at({12, 0, -3}, 0.5f), Sight::kBehind);
}

TEST(RangeImage, HostilePointsAreNoReturns) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();
  Cloud cloud;
  cloud.push(kNan, 1, 0), cloud.push(1, kNan, kNan), cloud.push(kInf, 0, 0), cloud.push(0, 0, 0);
  for (const bool planar : {false, true}) {
    const RangeImage image(cloud, Eigen::Vector3f::Zero(), planar);
    EXPECT_EQ(image.at({5, 0, 0}, 0.5f), Sight::kUnknown);
    EXPECT_EQ(image.at({kNan, 0, 0}, 0.5f), Sight::kUnknown);
  }
}

}  // namespace
}  // namespace scslam
