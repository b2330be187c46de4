#include "scslam/core/voxel_index.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace scslam {
namespace {

TEST(VoxelKey, PacksAndUnpacksNegativeCoordinates) {
  for (const VoxelCoord& v : {VoxelCoord(0, 0, 0), VoxelCoord(-1, 2, -3), VoxelCoord(1048575, -1048576, 77)}) {
    EXPECT_EQ(unpackVoxel(packVoxel(v)), v);
    EXPECT_NE(packVoxel(v), kNoVoxel);
  }
}

TEST(VoxelKey, FloorsTowardsMinusInfinity) {
  EXPECT_EQ(floorToInt(-0.25f), -1);
  EXPECT_EQ(floorToInt(-2.0f), -2);
  EXPECT_EQ(floorToInt(1.75f), 1);
}

// The index against std::map, through growth and through erasures that must close gaps in probing runs.
TEST(VoxelIndex, BehavesLikeAMapUnderRandomInsertionsAndErasures) {
  std::mt19937 random(7);
  VoxelIndex index;
  std::map<VoxelKey, int> reference;  // key -> payload
  std::vector<int> payload;           // by dense number
  for (int step = 0; step < 20000; ++step) {
    const auto pick = [&random] { return static_cast<std::int32_t>(random() % 24) - 12; };
    const VoxelKey key = packVoxel(pick(), pick(), pick());
    if (random() % 3 != 0) {
      const std::uint32_t i = index.findOrInsert(key);
      if (i == payload.size()) payload.push_back(step);
      reference.try_emplace(key, step);
    } else if (const std::uint32_t i = index.find(key); i != VoxelIndex::kAbsent) {
      index.erase(i);
      payload[i] = payload.back();
      payload.pop_back();
      reference.erase(key);
    }
  }
  ASSERT_EQ(index.size(), reference.size());
  ASSERT_EQ(payload.size(), reference.size());
  for (const auto& [key, value] : reference) {
    const std::uint32_t i = index.find(key);
    ASSERT_NE(i, VoxelIndex::kAbsent);
    EXPECT_EQ(payload[i], value);
    EXPECT_EQ(index.keys()[i], key);
  }
  EXPECT_EQ(index.find(packVoxel(500, 500, 500)), VoxelIndex::kAbsent);
}

TEST(VoxelIndex, IsRebuiltFromItsKeys) {
  VoxelIndex index;
  for (int i = 0; i < 1000; ++i) index.findOrInsert(packVoxel(i, -i, 3 * i));
  VoxelIndex copy;
  copy.assign(index.keys());
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(copy.find(packVoxel(i, -i, 3 * i)), static_cast<std::uint32_t>(i));
  copy.clear();
  EXPECT_EQ(copy.size(), 0u);
  EXPECT_EQ(copy.find(packVoxel(1, -1, 3)), VoxelIndex::kAbsent);
}

}  // namespace
}  // namespace scslam
