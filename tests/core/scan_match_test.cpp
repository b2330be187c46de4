#include "scslam/core/scan_match.h"

#include <gtest/gtest.h>

#include <limits>

#include "support/support.h"

namespace scslam {
namespace {

using test::IsNear;

ThreadPool& threads(int n) { return test::context(n).threads; }

SurfacePyramid mapOf(const Cloud& cloud, bool planar = false, double voxel_m = 0.5) {
  SurfacePyramid map(voxel_m, 3, SurfelRules::of(planar));
  map.insert(cloud, Pose::Identity());
  return map;
}

MatchOptions options(bool planar = false) {
  MatchOptions o;
  o.levels = {0, 2};
  o.planar = planar;
  return o;
}

Pose motion(double x, double y, double z, double yaw, double roll = 0) {
  Pose T = poseFromYaw(yaw, {x, y, z});
  T.rotate(Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()));
  return T;
}

/// Floor and two walls along x, `half_m` long to either side: nothing fixes x.
Cloud aCorridor(int points) {
  Cloud cloud;
  std::uint32_t state = 1;
  const auto uniform = [&state] {
    state = state * 1664525u + 1013904223u;
    return static_cast<float>(state >> 8) / 16777216.0f;
  };
  for (int i = 0; i < points; ++i) {
    const float x = 60 * (uniform() - 0.5f), noise = 0.01f * (uniform() + uniform() + uniform() - 1.5f);
    if (i % 3 == 0) cloud.push(x, 4 * (uniform() - 0.5f), noise);
    if (i % 3 == 1) cloud.push(x, 2 + noise, 3 * uniform());
    if (i % 3 == 2) cloud.push(x, -2 + noise, 3 * uniform());
  }
  return cloud;
}

TEST(MatchScan, RecoversAKnownMotionToAMillimetre) {
  const Pose T = motion(0.25, -0.2, 0.1, 0.06, 0.02);
  const SurfacePyramid map = mapOf(test::aRoom(60000, 1, 0.005));
  const Cloud scan = transformed(test::aRoom(8000, 2, 0.005), T.inverse());
  const MatchResult result = matchScan(map, scan, Pose::Identity(), options(), threads(1));
  EXPECT_TRUE(result.converged);
  EXPECT_EQ(result.degenerate_axes, 0);
  EXPECT_THAT(result.T_map_scan, IsNear(T, 0.0015, 0.02));
  EXPECT_GT(result.inlierRatio(), 0.85);
}

TEST(MatchScan, ErrorsAgreeWithItsInformation) {
  const SurfacePyramid map = mapOf(test::aRoom(60000, 1, 0.02));
  double sum = 0;
  constexpr int kRuns = 10;
  for (std::uint32_t seed = 0; seed < kRuns; ++seed) {
    const MatchResult r =
        matchScan(map, test::aRoom(4000, 100 + seed, 0.02), motion(0.05, 0, 0, 0.01), options(), threads(1));
    const Vector6d d = local(Pose::Identity(), r.T_map_scan);
    sum += d.dot(r.information * d) / 6;
  }
  // Independent noise is the best case; the information assumes correlated points and must not promise more.
  EXPECT_LT(sum / kRuns, 1.0);
  EXPECT_GT(sum / kRuns, 1e-3);
}

/// Points that stay in their 0.5 m voxel under any motion of a few centimetres: there the cost is smooth.
Cloud insideVoxels(const Cloud& cloud) {
  Cloud result;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f in_voxel = 2.0f * cloud.point(i) - (2.0f * cloud.point(i)).array().floor().matrix();
    if (in_voxel.minCoeff() > 0.1f && in_voxel.maxCoeff() < 0.9f) result.pushFrom(cloud, i);
  }
  return result;
}

TEST(Linearise, HessianIsTheDerivativeOfTheGradient) {
  const Pose off_grid = motion(0.21, 0.23, 0.27, 0);  // walls in the middle of voxels
  const SurfacePyramid map = mapOf(transformed(test::aRoom(60000, 1, 0.002), off_grid));
  const Cloud scan = insideVoxels(transformed(test::aRoom(6000, 2, 0.002), off_grid));
  ASSERT_GT(scan.size(), 1000u);
  MatchKernel kernel;
  kernel.width_m = 1e3;  // no robust weighting: the Gauss-Newton matrix is the Hessian up to second derivatives
  const auto gradient = [&](const Vector6d& d) {
    return linearise(map, {0, 0}, scan, retract(Pose::Identity(), d), kernel, threads(1)).g;
  };
  const Matrix6d H = linearise(map, {0, 0}, scan, Pose::Identity(), kernel, threads(1)).H;
  Matrix6d numeric;
  for (int axis = 0; axis < 6; ++axis) {
    const double h = axis < 3 ? 1e-2 : 1e-3;
    numeric.col(axis) = (gradient(h * Vector6d::Unit(axis)) - gradient(-h * Vector6d::Unit(axis))) / (2 * h);
  }
  EXPECT_LT((numeric - H).norm() / H.norm(), 0.01) << numeric << "\n\n" << H;
}

TEST(MatchScan, ACorridorLeavesOneAxisAndKeepsItsGuess) {
  const SurfacePyramid map = mapOf(aCorridor(60000));
  const Cloud scan = transformed(aCorridor(9000), motion(0, 0.1, 0.05, 0.01).inverse());
  const MatchResult result = matchScan(map, scan, motion(0.3, 0, 0, 0), options(), threads(1));
  EXPECT_EQ(result.degenerate_axes, 1);
  EXPECT_NEAR(result.T_map_scan.translation().x(), 0.3, 0.01);
  EXPECT_NEAR(result.T_map_scan.translation().y(), 0.1, 0.003);
  EXPECT_NEAR(yawOf(result.T_map_scan), 0.01, 2e-4);
  EXPECT_LT(result.information(0, 0), 1e-3 * result.information(1, 1));
}

TEST(MatchScan, AnOpenPlaneLeavesThreeAxes) {
  Cloud plane;
  for (int i = -60; i <= 60; ++i)
    for (int j = -60; j <= 60; ++j)
      plane.push(0.25f * static_cast<float>(i), 0.25f * static_cast<float>(j),
                 0.02f * static_cast<float>((i * 7 + j * 3) % 2));
  const SurfacePyramid map = mapOf(plane, false, 1.0);
  EXPECT_EQ(matchScan(map, plane, motion(0, 0, 0.05, 0), options(), threads(1)).degenerate_axes, 3);
}

TEST(MatchScan, PlanarMovesXYAndYawOnly) {
  Cloud room;
  for (int i = -200; i < 200; ++i) {
    const float t = 0.025f * static_cast<float>(i);
    room.push(t, -3, 0), room.push(t, 4, 0), room.push(-5, 0.7f * t, 0), room.push(5, 0.7f * t, 0);
  }
  const Pose T = motion(0.12, -0.08, 0, 0.05);
  const MatchResult result =
      matchScan(mapOf(room, true, 0.2), transformed(room, T.inverse()), Pose::Identity(), options(true), threads(1));
  EXPECT_THAT(result.T_map_scan, IsNear(T, 0.005, 0.1));
  EXPECT_EQ(result.T_map_scan.translation().z(), 0.0);
  EXPECT_EQ(result.T_map_scan.linear()(2, 2), 1.0);
  EXPECT_EQ(result.T_map_scan.linear()(2, 0), 0.0);
  EXPECT_EQ(result.T_map_scan.linear()(2, 1), 0.0);
  EXPECT_EQ(result.degenerate_axes, 0);
}

TEST(MatchScan, GivesTheSameBitsForAnyNumberOfThreads) {
  const SurfacePyramid map = mapOf(test::aRoom(30000));
  const Cloud scan = test::aRoom(7001, 2);
  const Pose guess = motion(0.2, 0.1, 0, 0.05);
  const MatchResult one = matchScan(map, scan, guess, options(), threads(1));
  for (const int n : {2, 4}) {
    const MatchResult many = matchScan(map, scan, guess, options(), threads(n));
    EXPECT_EQ(one.T_map_scan.matrix(), many.T_map_scan.matrix());
    EXPECT_EQ(one.system.H, many.system.H);
  }
}

TEST(MatchScan, BelievesAnInformedGuessWhereTheDataIsSilent) {
  const SurfacePyramid map = mapOf(aCorridor(60000));
  MatchOptions informed = options();
  informed.guess_information = Matrix6d::Identity() * 100;
  const MatchResult result = matchScan(map, aCorridor(9000), motion(0.2, 0.05, 0, 0), informed, threads(1));
  EXPECT_NEAR(result.T_map_scan.translation().x(), 0.2, 0.02);
  EXPECT_NEAR(result.T_map_scan.translation().y(), 0.0, 0.005);
}

TEST(MatchScan, DoesNotThrowOnEmptyTinyOrHostileInput) {
  const SurfacePyramid map = mapOf(test::aRoom(20000));
  const SurfacePyramid empty(0.5, 3, {});
  Cloud one, nans;
  one.push(1, 2, 0);
  for (int i = 0; i < 100; ++i) nans.push(std::numeric_limits<float>::quiet_NaN(), 0, 0);
  EXPECT_FALSE(matchScan(map, {}, Pose::Identity(), options(), threads(1)).converged);
  EXPECT_FALSE(matchScan(map, one, Pose::Identity(), options(), threads(1)).converged);
  EXPECT_FALSE(matchScan(map, nans, Pose::Identity(), options(), threads(1)).converged);
  EXPECT_FALSE(matchScan(empty, test::aRoom(100), Pose::Identity(), options(), threads(1)).converged);
  Pose broken = Pose::Identity();
  broken.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(matchScan(map, test::aRoom(100), broken, options(), threads(1)).converged);
}

TEST(SearchAndMatch, FindsAHalfTurnThatMatchingAloneMisses) {
  const Pose T = motion(1.1, -1.4, 0, 2.9);
  const SurfacePyramid map = mapOf(test::aRoom(60000));
  const Cloud scan = transformed(test::aRoom(6000, 2), T.inverse());
  PoseGrid grid;
  grid.yaw_range_rad = M_PI;
  grid.xy_range_m = 2;
  EXPECT_THAT(matchScan(map, scan, Pose::Identity(), options(), threads(1)).T_map_scan,
              ::testing::Not(IsNear(T, 0.5, 20)));
  const MatchResult found = searchAndMatch(map, scan, Pose::Identity(), grid, options(), threads(1));
  EXPECT_THAT(found.T_map_scan, IsNear(T, 0.005, 0.05));
  EXPECT_EQ(found.T_map_scan.matrix(),
            searchAndMatch(map, scan, Pose::Identity(), grid, options(), threads(2)).T_map_scan.matrix());
}

}  // namespace
}  // namespace scslam
