#include "scslam/registration/free_space.h"

#include <gmock/gmock.h>

#include <algorithm>

namespace scslam {
namespace {

/// An upright wall from (x, y0) to (x, y1), heights z0 .. z1, a point per 0.2 m.
void addWall(Cloud& cloud, float x, float y0, float y1, float z0, float z1) {
  for (float y = y0; y <= y1; y += 0.2f)
    for (float z = z0; z <= z1; z += 0.2f) cloud.push(x, y, z);
}

void addFloor(Cloud& cloud, float half_m, float z) {
  for (float x = -half_m; x <= half_m; x += 0.25f)
    for (float y = -half_m; y <= half_m; y += 0.25f) cloud.push(x, y, z);
}

std::size_t wallsOf(const Patches& patches) {
  return static_cast<std::size_t>(std::count(patches.wall.begin(), patches.wall.end(), 1));
}

TEST(Patches, WallsAreUprightAndTallerThanACar) {
  Cloud house, car, floor;
  addWall(house, 8.4f, -6, 6, 0, 6);
  addWall(car, 8.4f, -6, 6, 0, 1.5f);
  addFloor(floor, 10, -0.4f);
  EXPECT_GT(wallsOf(patchesOf(house, 1.0, false)), 50u);
  EXPECT_EQ(wallsOf(patchesOf(car, 1.0, false)), 0u);
  EXPECT_EQ(wallsOf(patchesOf(floor, 1.0, false)), 0u);
  EXPECT_GT(patchesOf(floor, 1.0, false).points.size(), 300u);
}

TEST(Patches, EveryLineOfPlanarDataIsAWall) {
  Cloud cloud;
  for (float y = -5; y < 5; y += 0.05f) cloud.push(3.1f, y, 0);
  const Patches patches = patchesOf(cloud, 0.3, true);
  EXPECT_GT(patches.points.size(), 25u);
  EXPECT_EQ(wallsOf(patches), patches.points.size());
}

TEST(FreeSpace, AWallThatTheScanSeesThroughCounts) {
  Cloud scan, submap;  // the scan sees a wall 20 m away; the submap has it, and half as long a one 10 m away
  addFloor(scan, 12, -1.6f), addWall(scan, 20.4f, -15, 15, -1.6f, 8);
  submap = scan;
  const RangeImage image(scan, Eigen::Vector3f::Zero(), false);
  const SightFigures same = sightOf(image, patchesOf(submap, 1.0, false), Pose::Identity(), 1.0f);
  EXPECT_GT(same.seen_walls, 100u);
  EXPECT_EQ(same.throughWalls(), 0.0);
  EXPECT_GT(same.explained(), 0.98);
  addWall(submap, 10.4f, -4, 4, -1.6f, 4);
  const SightFigures blocked = sightOf(image, patchesOf(submap, 1.0, false), Pose::Identity(), 1.0f);
  EXPECT_GT(blocked.throughWalls(), 0.05);
  EXPECT_LT(blocked.explained(), same.explained());
}

TEST(FreeSpace, AParkedCarThatLeftIsNoWall) {
  Cloud scan, submap;
  addFloor(scan, 12, -1.6f), addWall(scan, 20.4f, -15, 15, -1.6f, 8);
  submap = scan;
  addWall(submap, 10.4f, -4, 4, -1.6f, -0.2f);
  const RangeImage image(scan, Eigen::Vector3f::Zero(), false);
  const SightFigures figures = sightOf(image, patchesOf(submap, 1.0, false), Pose::Identity(), 1.0f);
  EXPECT_EQ(figures.throughWalls(), 0.0);
  EXPECT_GT(figures.through, 0u) << "it is missed all the same";
}

TEST(FreeSpace, WhatIsHiddenOrOutOfSightSaysNothing) {
  Cloud scan, hidden;
  addWall(scan, 10.4f, -8, 8, -1.6f, 4);
  addWall(hidden, 18.4f, -8, 8, -1.6f, 4);   // behind the scan's wall
  addWall(hidden, -12.4f, -8, 8, -1.6f, 4);  // the scan is blind to the rear
  const RangeImage image(scan, Eigen::Vector3f::Zero(), false);
  const SightFigures figures = sightOf(image, patchesOf(hidden, 1.0, false), Pose::Identity(), 1.0f);
  EXPECT_EQ(figures.seen, 0u);
  EXPECT_EQ(figures.throughWalls(), 0.0);
  EXPECT_EQ(figures.explained(), 1.0);
}

TEST(FreeSpace, PlacesThePatchesByTheTransform) {
  Cloud scan, wall;
  addWall(scan, 20.4f, -15, 15, -1.6f, 8);
  addWall(wall, 0.4f, -6, 6, -1.6f, 4);
  const RangeImage image(scan, Eigen::Vector3f::Zero(), false);
  const Patches patches = patchesOf(wall, 1.0, false);
  EXPECT_EQ(sightOf(image, patches, poseFromYaw(0, {20, 0, 0}), 1.0f).throughWalls(), 0.0);
  EXPECT_EQ(sightOf(image, patches, poseFromYaw(0, {12, 0, 0}), 1.0f).throughWalls(), 1.0);
}

}  // namespace
}  // namespace scslam
