#include "scslam/core/voxel_filter.h"

#include <gtest/gtest.h>

#include <limits>

namespace scslam {
namespace {

using Numbers = std::vector<std::uint32_t>;

TEST(FirstPerVoxel, KeepsTheFirstPointOfEachVoxelInInputOrder) {
  Cloud cloud;
  cloud.push(0.9f, 0.1f, 0.1f);
  cloud.push(-0.1f, 0.1f, 0.1f);  // the other side of a face
  cloud.push(0.2f, 0.8f, 0.9f);   // voxel of point 0
  cloud.push(5.0f, 5.0f, 5.0f);
  cloud.push(-0.9f, 0.9f, 0.9f);  // voxel of point 1
  EXPECT_EQ(firstPerVoxel(cloud, 1.0), (Numbers{0, 1, 3}));
}

TEST(FirstPerVoxel, DropsPointsOutsideTheRangeAndNonFiniteOnes) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  Cloud cloud;
  cloud.push(nan, 3, 0);
  cloud.push(inf, 0, 0);
  cloud.push(0.5f, 0, 0);
  cloud.push(3, 0, 0);
  cloud.push(0, 30, 0);
  cloud.push(1e38f, 1e38f, 0);  // its square is infinite
  EXPECT_EQ(firstPerVoxel(cloud, 0.5, 1.0, 20.0), (Numbers{3}));
}

TEST(FirstPerVoxel, OfNothingIsNothing) { EXPECT_TRUE(firstPerVoxel(Cloud{}, 1.0).empty()); }

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
