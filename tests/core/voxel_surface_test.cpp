#include "scslam/core/voxel_surface.h"

#include <gtest/gtest.h>

#include <random>

#include "support/support.h"

namespace scslam {
namespace {

/// A tilted square patch with noise along its normal, around `centre`.
Cloud aPatch(const Eigen::Vector3d& normal, double noise_m, int points = 150) {
  std::mt19937 random(3);
  std::normal_distribution<double> gauss(0, noise_m);
  const auto uniform = [&random] { return static_cast<double>(random()) / 4294967296.0 - 0.5; };
  const Eigen::Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
  Cloud cloud;
  for (int i = 0; i < points; ++i) {
    const Eigen::Vector3d p = 0.8 * uniform() * u + 0.8 * uniform() * v + gauss(random) * normal;
    cloud.push(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
  }
  return cloud;
}

Pose at(double x, double y, double z) {
  Pose T = Pose::Identity();
  T.translation() << x, y, z;
  return T;
}

TEST(VoxelSurface, FitsThePlaneOfItsPoints) {
  const Eigen::Vector3d normal = Eigen::Vector3d(1, -2, 5).normalized();
  VoxelSurface surface(2.0, {});
  surface.insert(aPatch(normal, 0.02), at(1, 1, 1));
  const Surfel* surfel = surface.find(packVoxel(0, 0, 0));
  ASSERT_NE(surfel, nullptr);
  EXPECT_NEAR(std::abs(normal.dot(Eigen::Vector3d(surfel->nx, surfel->ny, surfel->nz))), 1.0, 1e-3);
  EXPECT_NEAR(std::sqrt(surfel->variance), 0.02, 0.005);
  EXPECT_NEAR((Eigen::Vector3d(surfel->mx, surfel->my, surfel->mz) - Eigen::Vector3d(1, 1, 1)).norm(), 0, 0.1);
}

// A float 100 km from the origin has steps of 8 mm: the fit must not notice.
TEST(VoxelSurface, IsAsPreciseFarFromTheOrigin) {
  const Cloud patch = aPatch(Eigen::Vector3d(0.1, 0.2, 1).normalized(), 0.005);
  VoxelSurface near(2.0, {}), far(2.0, {});
  near.insert(patch, at(1, 1, 1));
  far.insert(patch, at(100001, -49999, 1));
  const Surfel* a = near.find(packVoxel(0, 0, 0));
  const Surfel* b = far.find(packVoxel(50000, -25000, 0));
  ASSERT_TRUE(a != nullptr && b != nullptr);
  EXPECT_NEAR(a->variance, b->variance, 1e-7);
  EXPECT_NEAR(a->mz, b->mz, 1e-4);
}

TEST(VoxelSurface, FitsNoPlaneToALineOrABall) {
  Cloud line, ball;
  std::mt19937 random(5);
  std::normal_distribution<float> gauss(0, 0.2f);
  for (int i = 0; i < 100; ++i) {
    line.push(0.02f * static_cast<float>(i - 50) * 0.8f, 0, 0);
    ball.push(gauss(random), gauss(random), gauss(random));
  }
  VoxelSurface lines(2.0, {}), balls(2.0, {});
  lines.insert(line, at(1, 1, 1));
  balls.insert(ball, at(1, 1, 1));
  EXPECT_TRUE(lines.occupied(packVoxel(0, 0, 0)));
  EXPECT_EQ(lines.find(packVoxel(0, 0, 0)), nullptr);
  EXPECT_EQ(balls.find(packVoxel(0, 0, 0)), nullptr);
}

TEST(VoxelSurface, PlanarNormalsAreHorizontal) {
  Cloud wall;
  for (int i = 0; i < 40; ++i) wall.push(0.02f * static_cast<float>(i - 20), 0, 0);
  VoxelSurface surface(1.0, SurfelRules::of(true));
  surface.insert(wall, at(0.5, 0.5, 0.25));
  const Surfel* surfel = surface.find(packVoxel(0, 0, 0));
  ASSERT_NE(surfel, nullptr);
  EXPECT_NEAR(std::abs(surfel->ny), 1, 1e-5);
  EXPECT_EQ(surfel->nz, 0);
}

TEST(VoxelSurface, ForgetsWhatIsFarWithinItsBudget) {
  VoxelSurface surface(1.0, {});
  Cloud row;
  for (int i = 0; i < 100; ++i) row.push(static_cast<float>(i) + 0.5f, 0.5f, 0.5f);
  surface.insert(row, Pose::Identity());
  ASSERT_EQ(surface.size(), 100u);
  surface.forgetBeyond(Eigen::Vector3d::Zero(), 10.0, 30);
  EXPECT_GE(surface.size(), 70u);
  for (int i = 0; i < 10; ++i) surface.forgetBeyond(Eigen::Vector3d::Zero(), 10.0, 30);
  EXPECT_NEAR(static_cast<double>(surface.size()), 10, 1);
  EXPECT_TRUE(surface.occupied(packVoxel(3, 0, 0)));
  EXPECT_FALSE(surface.occupied(packVoxel(50, 0, 0)));
}

TEST(VoxelSurface, KnowsWhichWayIsUpOnATiltedGround) {
  const Eigen::Vector3d up = Eigen::Vector3d(0.1, -0.05, 1).normalized();
  VoxelSurface surface(1.0, {});
  surface.insert(aPatch(up, 0.005, 400), at(0.5, 0.5, 0.5));
  EXPECT_GT(surface.upNear(Eigen::Vector3d::Zero(), 20).dot(up), 0.9995);
  EXPECT_EQ(VoxelSurface(1.0, {}).upNear(Eigen::Vector3d::Zero(), 20), Eigen::Vector3d::UnitZ());
}

TEST(VoxelSurface, ComesBackFromItsStateAndRefusesADamagedOne) {
  VoxelSurface surface(0.5, {});
  surface.insert(test::aRoom(20000), Pose::Identity());
  ByteWriter state;
  surface.save(state);
  VoxelSurface copy(0.5, {});
  ByteReader reader(state.bytes());
  copy.load(reader);
  ByteWriter again;
  copy.save(again);
  EXPECT_EQ(again.bytes(), state.bytes());
  ByteReader half(std::string_view(state.bytes()).substr(0, state.bytes().size() / 2));
  EXPECT_THROW(copy.load(half), Error);
}

}  // namespace
}  // namespace scslam
