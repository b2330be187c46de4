#include "scslam/mapping/voxel_set.h"

#include <random>
#include <set>

#include "support/support.h"

namespace scslam::test {
namespace {

/// Points along a drive that comes back, negative coordinates included.
std::vector<Eigen::Vector3d> drive() {
  std::mt19937 random(1);
  const auto noise = [&random](double width) { return width * (static_cast<double>(random() % 10000) / 10000 - 0.5); };
  std::vector<Eigen::Vector3d> points;
  for (int leg = 0; leg < 2; ++leg)
    for (int i = -100; i < 100; ++i)
      for (int n = 0; n < 100; ++n) points.push_back({(leg == 0 ? 4.0 : -4.0) * i + noise(40), noise(40), noise(3)});
  return points;
}

TEST(VoxelSet, KnowsExactlyWhatAPlainSetKnows) {
  VoxelSet voxels(0.5, 1 << 30, freshFolder());
  std::set<std::array<long, 3>> plain;
  for (const auto& p : drive()) {
    const std::array<long, 3> key{std::lround(std::floor(p.x() / 0.5)), std::lround(std::floor(p.y() / 0.5)),
                                  std::lround(std::floor(p.z() / 0.5))};
    ASSERT_EQ(voxels.insert(p), plain.insert(key).second) << p.transpose();
  }
}

TEST(VoxelSet, AnswersTheSameWithATinyBudgetAndStaysWithinIt) {
  const auto folder = freshFolder();
  {
    VoxelSet large(0.5, 1 << 30, folder / "unused"), small(0.5, 200000, folder);
    std::size_t i = 0, most = 0;
    for (const auto& p : drive()) {
      ASSERT_EQ(large.insert(p), small.insert(p));
      if (++i % 100 == 0) small.trim();
      most = std::max(most, i % 100 == 0 ? small.bytes() : 0);
    }
    EXPECT_GT(small.spilled(), 5u);
    EXPECT_LE(most, 200000u);
    EXPECT_GT(large.bytes(), 400000u);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder));  // cleans up after itself
}

}  // namespace
}  // namespace scslam::test
