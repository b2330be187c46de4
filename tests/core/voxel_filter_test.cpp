#include "scslam/core/voxel_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace scslam {
namespace {

using Numbers = std::vector<std::uint32_t>;

TEST(OnePerVoxel, KeepsOnePointOfEachVoxelInInputOrder) {
  Cloud cloud;
  cloud.push(0.9f, 0.1f, 0.1f);
  cloud.push(-0.1f, 0.1f, 0.1f);  // the other side of a face
  cloud.push(0.2f, 0.8f, 0.9f);   // voxel of point 0
  cloud.push(5.0f, 5.0f, 5.0f);
  cloud.push(-0.9f, 0.9f, 0.9f);  // voxel of point 1
  const Numbers kept = onePerVoxel(cloud, 1.0);
  ASSERT_EQ(kept.size(), 3u);
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
  const auto has = [&kept](std::uint32_t i) { return std::count(kept.begin(), kept.end(), i); };
  EXPECT_EQ(has(0) + has(2), 1);
  EXPECT_EQ(has(1) + has(4), 1);
  EXPECT_EQ(has(3), 1);
}

TEST(OnePerVoxel, TheOrderOfTheSweepAndRangeNoiseDoNotShiftAWall) {
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0.0f, 0.05f);
  constexpr float kWall_m = 5;
  double sum = 0;
  std::size_t n = 0;
  for (int sweep = 0; sweep < 200; ++sweep) {
    Cloud cloud;
    for (float azimuth = 0.8f; azimuth > 0.125f; azimuth -= 0.0005f) {  // clockwise along the wall, away from here
      const float range = kWall_m / std::sin(azimuth) + noise(random);
      cloud.push(range * std::cos(azimuth), range * std::sin(azimuth), 0.1f);
    }
    // The wall stands in the middle of its voxels.
    for (const std::uint32_t i : onePerVoxel(cloud, 2.0)) sum += static_cast<double>(cloud.y[i] - kWall_m), ++n;
  }
  const double noise_across_m = 0.05 * 0.3;  // the sine of the azimuth is 0.12 to 0.72
  EXPECT_NEAR(sum / static_cast<double>(n), 0, 3 * noise_across_m / std::sqrt(static_cast<double>(n)));
}

TEST(OnePerVoxel, DropsPointsOutsideTheRangeAndNonFiniteOnes) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  Cloud cloud;
  cloud.push(nan, 3, 0);
  cloud.push(inf, 0, 0);
  cloud.push(0.5f, 0, 0);
  cloud.push(3, 0, 0);
  cloud.push(0, 30, 0);
  cloud.push(1e38f, 1e38f, 0);  // its square is infinite
  EXPECT_EQ(onePerVoxel(cloud, 0.5, 1.0, 20.0), (Numbers{3}));
}

TEST(OnePerVoxel, OfNothingIsNothing) { EXPECT_TRUE(onePerVoxel(Cloud{}, 1.0).empty()); }

TEST(CentroidPerVoxel, IsTheMeanInOrderOfFirstAppearance) {
  Cloud cloud;
  cloud.push(7.5f, 0.5f, 0.5f);
  cloud.push(0.2f, 0.2f, 0.2f);
  cloud.push(0.4f, 0.6f, 0.8f);
  const Cloud means = centroidPerVoxel(cloud, 1.0);
  ASSERT_EQ(means.size(), 2u);
  EXPECT_EQ(means.point(0), Eigen::Vector3f(7.5f, 0.5f, 0.5f));
  EXPECT_TRUE(means.point(1).isApprox(Eigen::Vector3f(0.3f, 0.4f, 0.5f)));
}

}  // namespace
}  // namespace scslam
