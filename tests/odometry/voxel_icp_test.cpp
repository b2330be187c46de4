#include <Eigen/Eigenvalues>
#include <random>

#include "odometry/drive.h"
#include "scslam/core/deskew.h"
#include "scslam/odometry/odometry.h"

namespace scslam {
namespace {

using test::IsNear;
using ::testing::HasSubstr;

std::unique_ptr<Odometry> voxelIcp(const std::vector<std::string>& settings = {}) {
  const auto& entry = Registry<Odometry>::instance().find("voxel_icp");
  const auto params = entry.defaults();
  for (const auto& setting : settings) setParam(*params, setting);
  return entry.create(*params, test::context());
}

/// The drive without its recorded odometry.
test::Drive blind(test::Drive drive) {
  for (Scan& scan : drive.scans) scan.T_odom_base.reset();
  return drive;
}

TEST(VoxelIcp, StandingStillDoesNotDrift) {
  const auto odometry = voxelIcp();
  OdometryStep step;
  for (std::size_t k = 0; k < 30; ++k) {
    Scan scan = test::scanAt(k, poseFromYaw(0.3, {1, 1, 0}));
    scan.T_odom_base.reset();
    step = odometry->step(scan);
  }
  EXPECT_THAT(step.T_odom_base, IsNear(Pose::Identity(), 0.003, 0.03));
}

TEST(VoxelIcp, FindsItselfAgainAfterAStrongTurnBetweenTwoScans) {
  test::Drive drive = blind(test::arc(12));
  const Pose T_turned = drive.T_world_base.back() * poseFromYaw(1.9, {0.4, -0.3, 0});
  Scan turned = test::scanAt(12, T_turned);
  turned.T_odom_base.reset();
  const auto odometry = voxelIcp();
  for (const Scan& scan : drive.scans) odometry->step(scan);
  const OdometryStep step = odometry->step(turned);
  EXPECT_TRUE(step.quality.ok);
  EXPECT_THAT(step.quality.note, HasSubstr("rotation search"));
  EXPECT_THAT(step.T_odom_base, IsNear(drive.T_world_base[0].inverse() * T_turned, 0.02, 0.2));
}

TEST(VoxelIcp, NoticesAScanOfAnotherPlaceAndPredicts) {
  const test::Drive drive = blind(test::arc(12));
  const auto odometry = voxelIcp();
  OdometryStep last;
  for (const Scan& scan : drive.scans) last = odometry->step(scan);
  std::mt19937 random(1);
  Scan garbage = drive.scans.back();
  garbage.stamp += std::chrono::milliseconds(100);
  for (std::size_t i = 0; i < garbage.cloud.size(); ++i) {
    const auto coordinate = [&random] { return 16.0f * static_cast<float>(random()) / 4294967296.0f - 8.0f; };
    garbage.cloud.x[i] = coordinate(), garbage.cloud.y[i] = coordinate(), garbage.cloud.z[i] = coordinate();
  }
  const OdometryStep step = odometry->step(garbage);
  EXPECT_FALSE(step.quality.ok);
  EXPECT_THAT(step.quality.note, HasSubstr("does not fit"));
  EXPECT_THAT(last.T_odom_base.inverse() * step.T_odom_base, IsNear(poseFromYaw(0.035, {0.15, 0.01, 0}), 0.03, 0.5));
  EXPECT_GT(step.covariance(0, 0), 0.05 * 0.05);
}

TEST(VoxelIcp, TakesRecordedOdometryThroughAJump) {
  test::Drive drive = test::arc(3);
  const Pose T_far = drive.T_world_base.back() * poseFromYaw(-2.0, {2.5, 1.5, 0});
  const auto odometry = voxelIcp();
  for (const Scan& scan : drive.scans) odometry->step(scan);
  const OdometryStep step = odometry->step(test::scanAt(3, T_far));
  EXPECT_THAT(step.T_odom_base, IsNear(drive.T_world_base[0].inverse() * T_far, 0.02, 0.2));
  EXPECT_TRUE(step.quality.note.empty()) << step.quality.note;
}

/// One sweep while moving with `twist`; its points carry their times.
Scan sweep(std::size_t index, const Pose& T_world_base, const Vector6d& twist) {
  Scan scan = test::scanAt(index, T_world_base, 8000);
  scan.T_base_sensor = Pose::Identity();
  const Cloud room = test::aRoom(8000, static_cast<std::uint32_t>(index) + 10, 0.01);
  for (std::size_t i = 0; i < room.size(); ++i) {
    const double dt = 0.1 * static_cast<double>(i) / static_cast<double>(room.size());
    const Pose T_world_now = T_world_base * retract(Pose::Identity(), dt * twist);
    const Eigen::Vector3f p = (T_world_now.inverse() * room.point(i).cast<double>()).cast<float>();
    scan.cloud.x[i] = p.x(), scan.cloud.y[i] = p.y(), scan.cloud.z[i] = p.z();
    scan.cloud.dt.push_back(static_cast<float>(dt));
  }
  scan.T_odom_base.reset();
  return scan;
}

struct SweepErrors {
  double translation_m = 0;  ///< drift since the fifth scan (nothing can compensate the first)
  double cloud_m = 0;        ///< mean distance of the last cloud's points from where they were at the stamp
};

SweepErrors driveSweeps(const std::string& mode, bool already_compensated) {
  Vector6d twist;
  twist << 3, 0, 0, 0, 0, 0.9;
  const auto odometry = voxelIcp({"deskew=" + mode, "min_range_m=0.001"});
  Pose T = poseFromYaw(0, {-3, -2, 0});
  Pose T_odom_world;
  SweepErrors errors;
  for (std::size_t k = 0; k < 16; ++k) {
    Scan scan = sweep(k, T, twist);
    if (already_compensated) deskew(scan.cloud, twist);
    const OdometryStep step = odometry->step(scan);
    if (k <= 4) T_odom_world = step.T_odom_base * T.inverse();
    errors.translation_m = local(T_odom_world * T, step.T_odom_base).head<3>().norm();
    Cloud truth = scan.cloud;
    if (!already_compensated) deskew(truth, twist);
    errors.cloud_m = 0;
    for (std::size_t i = 0; i < truth.size(); ++i)
      errors.cloud_m +=
          static_cast<double>((truth.point(i) - step.cloud.point(i)).norm()) / static_cast<double>(truth.size());
    T = T * retract(Pose::Identity(), 0.1 * twist);
  }
  return errors;
}

TEST(VoxelIcp, AutoDeskewCompensatesAMovingSweep) {
  const SweepErrors with = driveSweeps("auto", false), without = driveSweeps("off", false);
  EXPECT_LT(with.cloud_m, 0.03);
  EXPECT_GT(without.cloud_m, 0.1) << "the drive must be fast enough to tell";
  EXPECT_LT(with.translation_m, 0.05);
}

TEST(VoxelIcp, AutoDeskewLeavesACompensatedSweepAlone) {
  const SweepErrors automatic = driveSweeps("auto", true), forced = driveSweeps("on", true);
  EXPECT_LT(automatic.cloud_m, 0.01);
  EXPECT_GT(forced.cloud_m, 0.1);
  EXPECT_LT(automatic.translation_m, 0.03);
}

TEST(VoxelIcp, PlanarScansStayInTheirPlane) {
  const auto odometry = voxelIcp();
  Pose T = Pose::Identity();
  OdometryStep step;
  std::mt19937 random(2);
  for (std::size_t k = 0; k < 20; ++k) {
    Scan scan;
    scan.planar = true;
    scan.stamp = stampFromSeconds(10 + 0.1 * static_cast<double>(k));
    for (int i = 0; i < 360; ++i) {  // rays from the robot to the walls of a 10 x 7 m room with a corner cut off
      const double a = i * M_PI / 180 + 0.001 * static_cast<double>(random() % 10);
      const Eigen::Vector2d d(std::cos(a), std::sin(a));
      const Eigen::Vector2d dw = T.linear().topLeftCorner<2, 2>() * d, o = T.translation().head<2>();
      double range = 1e9;
      const double walls[5][3] = {{1, 0, 6}, {-1, 0, 4}, {0, 1, 3}, {0, -1, 4}, {0.6, 0.8, 5}};
      for (const auto& w : walls) {
        const double approach = w[0] * dw.x() + w[1] * dw.y();
        if (approach > 1e-9) range = std::min(range, (w[2] - w[0] * o.x() - w[1] * o.y()) / approach);
      }
      scan.cloud.push(static_cast<float>(range * d.x()), static_cast<float>(range * d.y()), 0);
    }
    step = odometry->step(scan);
    EXPECT_TRUE(step.quality.ok) << k;
    EXPECT_THAT(step.T_odom_base, IsNear(T, 0.02, 0.3)) << k;
    T = T * poseFromYaw(0.05, {0.08, 0, 0});
  }
  EXPECT_EQ(step.T_odom_base.translation().z(), 0.0);
  EXPECT_EQ(step.T_odom_base.linear()(2, 2), 1.0);
  EXPECT_EQ(step.quality.degenerate_axes, 0);
}

TEST(VoxelIcp, SaysThatACorridorLeavesItsAxisOpen) {
  const auto odometry = voxelIcp();
  std::mt19937 random(4);
  const auto uniform = [&random] { return static_cast<float>(random()) / 4294967296.0f; };
  OdometryStep step;
  for (std::size_t k = 0; k < 4; ++k) {
    Scan scan;
    scan.stamp = stampFromSeconds(10 + 0.1 * static_cast<double>(k));
    for (int i = 0; i < 12000; ++i) {
      const float x = 60 * (uniform() - 0.5f), noise = 0.01f * (uniform() + uniform() - 1);
      if (i % 3 == 0) scan.cloud.push(x, 4 * (uniform() - 0.5f), noise - 1);
      if (i % 3 == 1) scan.cloud.push(x, 2 + noise, 3 * uniform() - 1);
      if (i % 3 == 2) scan.cloud.push(x, -2 + noise, 3 * uniform() - 1);
    }
    step = odometry->step(scan);
  }
  EXPECT_TRUE(step.quality.ok);
  EXPECT_EQ(step.quality.degenerate_axes, 1);
  EXPECT_GT(step.covariance(0, 0), 100 * step.covariance(1, 1));
}

}  // namespace
}  // namespace scslam
