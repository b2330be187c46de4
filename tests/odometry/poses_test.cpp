#include <fstream>

#include "odometry/drive.h"
#include "scslam/core/trajectory.h"
#include "scslam/odometry/odometry.h"

namespace scslam {
namespace {

using test::IsNear;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::unique_ptr<Odometry> posesFrom(const std::string& file) {
  const auto& entry = Registry<Odometry>::instance().find("poses");
  const auto params = entry.defaults();
  setParam(*params, "file=" + file);
  return entry.create(*params, test::context());
}

std::string write(const std::string& name, const std::string& text) {
  const auto file = test::freshFolder() / name;
  std::ofstream(file) << text;
  return file.string();
}

TEST(Poses, InterpolatesATumFileAtTheStampOfTheScan) {
  std::vector<StampedPose> poses;
  for (int i = 0; i < 5; ++i)
    poses.push_back({stampFromSeconds(999.95 + 0.1 * i), poseFromYaw(0.1 * i, {1.0 * i, 0, 0})});
  const auto odometry = posesFrom(write("poses.tum", formatTum(poses)));
  odometry->begin(3, Pose::Identity());
  const OdometryStep step = odometry->step(test::scanAt(0, Pose::Identity()));
  EXPECT_THAT(step.T_odom_base, IsNear(poseFromYaw(0.05, {0.5, 0, 0}), 1e-6, 1e-4));
}

TEST(Poses, TakesRowIOfAKittiFileAndItsReferenceFrame) {
  const Pose T_base_camera = poseFromYaw(1.2, {0.3, -0.1, 1.5});
  std::vector<Pose> T_world_base, T_world_camera;
  for (int i = 0; i < 3; ++i) {
    T_world_base.push_back(poseFromYaw(0.2 * i, {1.0 * i, 0.1, 0}));
    T_world_camera.push_back(T_world_base.back() * T_base_camera);
  }
  const auto odometry = posesFrom(write("poses.txt", formatKitti(T_world_camera)));
  odometry->begin(3, T_base_camera);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_THAT(odometry->step(test::scanAt(i, Pose::Identity())).T_odom_base, IsNear(T_world_base[i], 1e-9, 1e-6));
}

TEST(Poses, SaysBothNumbersWhenAKittiFileDoesNotFitTheScans) {
  const auto odometry = posesFrom(write("poses.txt", formatKitti(std::vector<Pose>(7, Pose::Identity()))));
  EXPECT_THAT([&] { odometry->begin(9, Pose::Identity()); },
              ThrowsMessage<Error>(AllOf(HasSubstr("7 poses"), HasSubstr("9 scans"))));
}

TEST(Poses, NamesTheStampWithoutAPose) {
  const auto odometry = posesFrom(write("poses.tum", formatTum({{stampFromSeconds(5), Pose::Identity()}})));
  odometry->begin(1, Pose::Identity());
  EXPECT_THAT([&] { odometry->step(test::scanAt(0, Pose::Identity())); },
              ThrowsMessage<Error>(HasSubstr("1000.000000000")));
  const auto recorded = posesFrom("");
  Scan bare = test::scanAt(0, Pose::Identity());
  bare.T_odom_base.reset();
  EXPECT_THAT([&] { recorded->step(bare); }, ThrowsMessage<Error>(HasSubstr("1000.000000000")));
}

TEST(Poses, CovarianceGrowsWithTheStep) {
  const auto covariance = [](double metres) {
    const auto odometry = posesFrom("");
    odometry->step(test::scanAt(0, Pose::Identity()));
    return odometry->step(test::scanAt(1, poseFromYaw(0, {metres, 0, 0}))).covariance;
  };
  EXPECT_GT(covariance(4.0)(0, 0), 2 * covariance(1.0)(0, 0));
  EXPECT_GT(covariance(0.0)(0, 0), 0);
}

}  // namespace
}  // namespace scslam
