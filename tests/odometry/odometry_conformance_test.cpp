// What every registered front-end must do, on a drive whose truth is known.
#include <Eigen/Eigenvalues>
#include <cmath>

#include "scslam/core/file.h"
#include "scslam/core/trajectory.h"
#include "scslam/odometry/odometry.h"
#include "support/support.h"
#include "support/town.h"

namespace scslam {
namespace {

using test::IsNear;

constexpr int kScans = 14;

/// Scans of a drive along a street; they carry the truth as the recording's own poses.
const std::vector<Scan>& drive() {
  static const std::vector<Scan> scans = [] {
    const test::Town town(2);
    const auto truth = test::aroundTheBlock(0.8, 0.1);
    std::vector<Scan> made;
    for (std::size_t i = 0; i < kScans; ++i) {
      Scan scan;
      scan.index = i;
      scan.stamp = stampFromSeconds(0.1 * static_cast<double>(i));
      scan.cloud = town.scan(truth[i], static_cast<std::uint32_t>(i), 20000);
      scan.T_odom_base = truth.front().inverse() * truth[i];
      made.push_back(std::move(scan));
    }
    return made;
  }();
  return scans;
}

class FrontEnd : public testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<Odometry> frontEnd(int threads = 1) {
    auto odometry = Registry<Odometry>::instance().create(GetParam(), test::context(threads));
    odometry->begin(kScans, Pose::Identity());
    return odometry;
  }
};

TEST_P(FrontEnd, FollowsTheDrive) {
  const auto odometry = frontEnd();
  Pose T_first_base = Pose::Identity();
  for (const Scan& scan : drive()) {
    const OdometryStep step = odometry->step(scan);
    EXPECT_TRUE(step.quality.ok) << scan.index << ": " << step.quality.note;
    EXPECT_GT(step.cloud.size(), scan.cloud.size() / 2);
    if (scan.index == 0) {
      T_first_base = step.T_odom_base;
      EXPECT_EQ(step.covariance, Matrix6d::Zero());
      continue;
    }
    EXPECT_THAT(T_first_base.inverse() * step.T_odom_base, IsNear(*scan.T_odom_base, 0.05, 0.3)) << scan.index;
    const Vector6d eigenvalues = step.covariance.selfadjointView<Eigen::Lower>().eigenvalues();
    EXPECT_GT(eigenvalues.minCoeff(), 0);
    EXPECT_LT(eigenvalues.maxCoeff(), 0.1);
  }
}

TEST_P(FrontEnd, GoesOnBitForBitFromASavedState) {
  const auto whole = frontEnd(), first = frontEnd(), second = frontEnd();
  for (std::size_t i = 0; i < kScans; ++i) {
    const OdometryStep expected = whole->step(drive()[i]);
    if (i == 7) {
      ByteWriter state;
      first->save(state);
      ByteReader reader(state.bytes());
      second->load(reader);
      EXPECT_TRUE(reader.done());
    }
    const OdometryStep step = (i < 7 ? first : second)->step(drive()[i]);
    EXPECT_EQ(step.T_odom_base.matrix(), expected.T_odom_base.matrix()) << i;
    EXPECT_EQ(step.covariance, expected.covariance) << i;
    EXPECT_EQ(step.cloud.x, expected.cloud.x) << i;
  }
}

TEST_P(FrontEnd, SameBitsForAnyNumberOfThreads) {
  const auto one = frontEnd(1), two = frontEnd(2);
  for (const Scan& scan : drive())
    EXPECT_EQ(one->step(scan).T_odom_base.matrix(), two->step(scan).T_odom_base.matrix());
}

TEST_P(FrontEnd, EmptyNanAndTinyScansAreNoted) {
  const auto odometry = frontEnd();
  odometry->step(drive()[0]);
  Scan empty = drive()[1];
  empty.cloud = Cloud();
  EXPECT_FALSE(odometry->step(empty).quality.ok);
  Scan nan = drive()[2];
  for (float& x : nan.cloud.x) x = NAN;
  const OdometryStep step = odometry->step(nan);
  EXPECT_FALSE(step.quality.ok);
  EXPECT_TRUE(step.T_odom_base.matrix().allFinite());
  Scan one = drive()[3];
  one.cloud = Cloud();
  one.cloud.push(3, 0, 0);
  EXPECT_TRUE(odometry->step(one).T_odom_base.matrix().allFinite());
  EXPECT_TRUE(odometry->step(drive()[4]).T_odom_base.matrix().allFinite());
}

INSTANTIATE_TEST_SUITE_P(All, FrontEnd, testing::ValuesIn(Registry<Odometry>::instance().names()));

TEST(ExternalPoses, AFileIsInterpolatedAtTheScansStamp) {
  const auto folder = test::freshFolder();
  writeFileAtomically(folder / "t.tum", formatTum({{stampFromSeconds(0), Pose::Identity()},
                                                   {stampFromSeconds(1), poseFromYaw(0.2, {2, 0, 0})}}));
  auto params = Registry<Odometry>::instance().find("poses").defaults();
  setParam(*params, "file=\"" + (folder / "t.tum").string() + "\"");
  const auto odometry = Registry<Odometry>::instance().create("poses", *params, test::context());
  Scan scan = drive()[0];
  scan.stamp = stampFromSeconds(0.5);
  EXPECT_THAT(odometry->step(scan).T_odom_base, IsNear(poseFromYaw(0.1, {1, 0, 0}), 1e-6, 1e-6));
  scan.stamp = stampFromSeconds(3);
  EXPECT_THROW(odometry->step(scan), Error);
}

TEST(ExternalPoses, CameraPosesAreTurnedIntoPosesOfTheBase) {
  const auto folder = test::freshFolder();
  const Pose T_base_camera = retract(Pose::Identity(), (Vector6d() << 0.3, 0.1, -0.2, 1, -1, 0.5).finished());
  const Pose T_world_base = poseFromYaw(0.7, {5, 6, 0});
  writeFileAtomically(folder / "k.txt", formatKitti({T_world_base * T_base_camera}));
  auto params = Registry<Odometry>::instance().find("poses").defaults();
  setParam(*params, "file=\"" + (folder / "k.txt").string() + "\"");
  const auto odometry = Registry<Odometry>::instance().create("poses", *params, test::context());
  odometry->begin(1, T_base_camera);
  EXPECT_THAT(odometry->step(drive()[0]).T_odom_base, IsNear(T_world_base, 1e-9, 1e-6));
  EXPECT_THROW(odometry->begin(2, Pose::Identity()), Error) << "one row short";
}

}  // namespace
}  // namespace scslam
