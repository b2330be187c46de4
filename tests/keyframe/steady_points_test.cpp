#include "scslam/keyframe/steady_points.h"

#include <gtest/gtest.h>

namespace scslam {
namespace {

/// A post at the origin that every scan shows, two metres high, and a car that is elsewhere in each.
std::vector<Cloud> scansOfAPostAndACar(int n) {
  std::vector<Cloud> scans(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    Cloud& scan = scans[static_cast<std::size_t>(i)];
    scan.push(0.05f * static_cast<float>(i % 3), 0, 2.0f * static_cast<float>(i % 2));
    scan.push(10 + 3 * static_cast<float>(i), 4, 0);
  }
  return scans;
}

TEST(SteadyPoints, KeepWhatStandsAndLeaveOutWhatMoves) {
  const std::vector<Cloud> scans = scansOfAPostAndACar(9);
  const SteadyPoints steady(scans, 0.7, true);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const Cloud kept = steady.of(i, 5);
    ASSERT_EQ(kept.size(), 1u);
    EXPECT_EQ(kept.point(0), scans[i].point(0));
    EXPECT_EQ(steady.of(i, 1).size(), 2u);
    EXPECT_EQ(steady.of(i, 10).size(), 0u);  // there are nine
  }
}

TEST(SteadyPoints, HeightsCountUnlessTheDataIsPlanar) {
  const std::vector<Cloud> scans = scansOfAPostAndACar(8);  // four show the post's foot, four its top
  EXPECT_EQ(SteadyPoints(scans, 0.7, false).of(0, 4).size(), 1u);
  EXPECT_EQ(SteadyPoints(scans, 0.7, false).of(0, 5).size(), 0u);
  EXPECT_EQ(SteadyPoints(scans, 0.7, true).of(0, 8).size(), 1u);
}

TEST(SteadyPoints, OfManyScansNeighboursCountAsOne) {
  const std::vector<Cloud> scans = scansOfAPostAndACar(100);
  const SteadyPoints steady(scans, 0.7, true);
  EXPECT_EQ(steady.of(99, 50).size(), 1u);
  EXPECT_EQ(steady.of(99, 51).size(), 0u);
}

TEST(SteadyPoints, ScansWithoutPointsAreNoOnesWitness) {
  const std::vector<Cloud> scans(3);
  EXPECT_TRUE(SteadyPoints(scans, 0.7, true).of(1, 1).empty());
}

}  // namespace
}  // namespace scslam
