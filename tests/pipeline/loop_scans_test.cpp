// What loops are registered with: strong echoes that the scans around confirm.
#include "scslam/pipeline/loop_scans.h"

#include <gtest/gtest.h>

namespace scslam {
namespace {

/// Keyframes 2 m apart along x; each shows a post at x = 10 and an echo that no other does.
struct Drive {
  std::vector<Keyframe> keyframes;
  std::vector<Pose> T_map_base;
  KeyframeCloud cloud_of;

  explicit Drive(std::size_t n) {
    for (std::size_t k = 0; k < n; ++k) {
      Keyframe keyframe;
      keyframe.id = static_cast<KeyframeId>(k);
      keyframe.travelled_m = 2.0 * static_cast<double>(k);
      keyframe.planar = true;
      keyframes.push_back(keyframe);
      T_map_base.push_back(poseFromYaw(0.2 * static_cast<double>(k), {keyframe.travelled_m, 0, 0}));
    }
    cloud_of = [this](KeyframeId k) {
      const auto cloud = std::make_shared<Cloud>();
      for (const Eigen::Vector3d& p_map : {Eigen::Vector3d(10, 1, 0), Eigen::Vector3d(10, 20 + 5.0 * k, 0)}) {
        const Eigen::Vector3f p = (T_map_base[k].inverse() * p_map).cast<float>();
        cloud->push(p.x(), p.y(), p.z());
      }
      return std::shared_ptr<const Cloud>(cloud);
    };
  }
};

RegistrationParams steady(int scans) {
  RegistrationParams params;
  params.steady_scans = scans;
  return params;
}

TEST(LoopScan, LeavesOutWeakEchoesWhereStrengthIsKnown) {
  Cloud cloud;
  cloud.push(1, 0, 0), cloud.push(5, 0, 0);
  RegistrationParams params;
  params.min_intensity = 60;
  EXPECT_EQ(loopScan(cloud, params).size(), 2u);
  cloud.intensity = {59, 60};
  ASSERT_EQ(loopScan(cloud, params).size(), 1u);
  EXPECT_EQ(loopScan(cloud, params).x[0], 5);
  params.min_intensity = 0;
  EXPECT_EQ(loopScan(cloud, params).size(), 2u);
}

TEST(LoopTarget, HoldsWhatTheScansAroundConfirm) {
  const Drive drive(9);
  ThreadPool threads(2);
  const auto target = [&](int scans) {
    return loopTarget(4, drive.keyframes, 9, drive.T_map_base, drive.cloud_of, steady(scans), threads);
  };
  EXPECT_EQ(target(1).submap.size(), 18u);
  const LoopTarget confirmed = target(5);
  ASSERT_EQ(confirmed.submap.size(), 9u);
  const Eigen::Vector3f post = (drive.T_map_base[4].inverse() * Eigen::Vector3d(10, 1, 0)).cast<float>();
  for (std::size_t i = 0; i < 9; ++i) EXPECT_LT((confirmed.submap.point(i) - post).norm(), 1e-4);
  ASSERT_EQ(confirmed.clouds.size(), 9u);
  EXPECT_EQ(confirmed.clouds[0]->size(), 2u);  // what a scan saw is whole: free space is judged by it
}

TEST(LoopQuery, IsTheScanAsTheOnesAroundItConfirmIt) {
  const Drive drive(9);
  const auto query = [&](KeyframeId k, KeyframeId limit, int scans) {
    return loopQuery(k, drive.keyframes, limit, drive.T_map_base, drive.cloud_of, steady(scans));
  };
  EXPECT_EQ(query(8, 9, 1).size(), 2u);
  EXPECT_EQ(query(8, 9, 5).size(), 1u);
  EXPECT_EQ(query(1, 2, 5).size(), 2u);  // two scans: half of them is one
  EXPECT_EQ(query(2, 3, 5).size(), 1u);  // half of three are two
}

}  // namespace
}  // namespace scslam
