#include "scslam/core/deskew.h"

#include <gtest/gtest.h>

#include <limits>

#include "support/support.h"

namespace scslam {
namespace {

TEST(Deskew, PutsEveryPointWhereItWouldHaveBeenSeenAtTheStamp) {
  Vector6d twist;
  twist << 12, -1, 0.3, 0.2, -0.1, 1.5;
  const Cloud room = test::aRoom(5000);
  Cloud seen;
  seen.dt.resize(0);
  for (std::size_t i = 0; i < room.size(); ++i) {
    const float dt = 0.1f * static_cast<float>(i) / static_cast<float>(room.size());
    const Pose T_start_now = retract(Pose::Identity(), static_cast<double>(dt) * twist);
    const Eigen::Vector3f p = (T_start_now.inverse() * room.point(i).cast<double>()).cast<float>();
    seen.push(p.x(), p.y(), p.z());
    seen.dt.push_back(dt);
  }
  deskew(seen, twist);
  for (std::size_t i = 0; i < room.size(); ++i) EXPECT_LT((seen.point(i) - room.point(i)).norm(), 1e-4f) << i;
}

TEST(Deskew, LeavesCloudsWithoutTimesAndWithoutMotionAlone) {
  Cloud cloud = test::aRoom(100);
  const Cloud before = cloud;
  deskew(cloud, Vector6d::Ones());
  EXPECT_EQ(cloud.x, before.x);
  cloud.dt.assign(100, 0.05f);
  cloud.dt[0] = 0.0f;
  deskew(cloud, Vector6d::Zero());
  EXPECT_EQ(cloud.x, before.x);
}

TEST(Deskew, TakesNegativeAndNonFiniteTimes) {
  Cloud cloud;
  for (int i = 0; i < 3; ++i) cloud.push(1, 0, 0);
  cloud.dt = {-0.1f, 0.0f, std::numeric_limits<float>::quiet_NaN()};
  deskew(cloud, 10 * Vector6d::Unit(0));
  EXPECT_NEAR(cloud.x[0], 0, 1e-5);
  EXPECT_NEAR(cloud.x[1], 1, 1e-5);
  EXPECT_NEAR(cloud.x[2], 1, 1e-5);
  EXPECT_NEAR(sweepDuration(cloud), 0.1, 1e-6);
}

}  // namespace
}  // namespace scslam
