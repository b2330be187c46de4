// What every odometry front-end promises (odometry/odometry.h), checked on each that is registered.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>

#include "odometry/drive.h"
#include "scslam/odometry/odometry.h"

namespace scslam {
namespace {

using test::IsNear;

class OdometryConformance : public ::testing::TestWithParam<std::string> {
 protected:
  /// With default parameters; `poses` then takes the poses the scans carry.
  static std::unique_ptr<Odometry> make(int threads = 1) {
    auto odometry = Registry<Odometry>::instance().create(GetParam(), test::context(threads));
    odometry->begin(std::nullopt, Pose::Identity());
    return odometry;
  }
};

TEST_P(OdometryConformance, FollowsADriveThroughARoom) {
  const test::Drive drive = test::arc(25);
  const auto odometry = make();
  Pose T_odom_world;
  for (std::size_t k = 0; k < drive.scans.size(); ++k) {
    const OdometryStep step = odometry->step(drive.scans[k]);
    EXPECT_TRUE(step.quality.ok) << k << ": " << step.quality.note;
    if (k == 0) T_odom_world = step.T_odom_base * drive.T_world_base[0].inverse();
    EXPECT_THAT(T_odom_world.inverse() * step.T_odom_base, IsNear(drive.T_world_base[k], 0.02, 0.2)) << k;
  }
}

TEST_P(OdometryConformance, FirstStepHasZeroCovarianceAndLaterOnesAreProper) {
  const test::Drive drive = test::arc(4);
  const auto odometry = make();
  EXPECT_EQ(odometry->step(drive.scans[0]).covariance, Matrix6d::Zero());
  for (std::size_t k = 1; k < 4; ++k) {
    const Matrix6d C = odometry->step(drive.scans[k]).covariance;
    EXPECT_EQ(C, C.transpose());
    EXPECT_GT(C.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0);
    EXPECT_LT(C.diagonal().head<3>().maxCoeff(), 0.05 * 0.05);
    EXPECT_GT(C.diagonal().head<3>().minCoeff(), 1e-8) << "no step is known to 0.1 mm";
  }
}

TEST_P(OdometryConformance, CloudIsInFrameBaseFiniteAndKeepsItsFields) {
  Scan scan = test::arc(1).scans[0];
  scan.cloud.x[7] = std::numeric_limits<float>::quiet_NaN();
  const Eigen::Vector3d expected = scan.T_base_sensor * scan.cloud.point(0).cast<double>();
  const OdometryStep step = make()->step(scan);
  ASSERT_GT(step.cloud.size(), 1000u);
  EXPECT_LT(step.cloud.size(), scan.cloud.size());
  EXPECT_EQ(step.cloud.intensity.size(), step.cloud.size());
  EXPECT_LT((step.cloud.point(0).cast<double>() - expected).norm(), 1e-4);
  for (std::size_t i = 0; i < step.cloud.size(); ++i) ASSERT_TRUE(step.cloud.point(i).allFinite());
}

TEST_P(OdometryConformance, UselessScansAreNotOkAndNeverThrow) {
  const test::Drive drive = test::arc(6);
  Scan empty = drive.scans[2], nans = drive.scans[3], one = drive.scans[4];
  empty.cloud = {};
  nans.cloud.x.assign(nans.cloud.size(), std::numeric_limits<float>::quiet_NaN());
  one.cloud = {};
  const auto odometry = make();
  EXPECT_FALSE(make()->step(empty).quality.ok) << "as the first scan";
  odometry->step(drive.scans[0]);
  odometry->step(drive.scans[1]);
  for (const Scan& scan : {empty, nans, one}) {
    const OdometryStep step = odometry->step(scan);
    EXPECT_FALSE(step.quality.ok);
    EXPECT_FALSE(step.quality.note.empty());
    EXPECT_TRUE(isRigid(step.T_odom_base));
    EXPECT_TRUE(step.covariance.allFinite());
  }
  const OdometryStep after = odometry->step(drive.scans[5]);
  EXPECT_TRUE(after.quality.ok) << after.quality.note;
}

TEST_P(OdometryConformance, ContinuesFromItsStateWithTheSameBits) {
  const test::Drive drive = test::arc(14);
  const auto whole = make();
  for (std::size_t k = 0; k < 10; ++k) whole->step(drive.scans[k]);
  ByteWriter state;
  whole->save(state);
  const auto resumed = make();
  ByteReader reader(state.bytes());
  resumed->load(reader);
  EXPECT_TRUE(reader.done());
  for (std::size_t k = 10; k < drive.scans.size(); ++k) {
    const OdometryStep a = whole->step(drive.scans[k]), b = resumed->step(drive.scans[k]);
    EXPECT_EQ(a.T_odom_base.matrix(), b.T_odom_base.matrix()) << k;
    EXPECT_EQ(a.covariance, b.covariance) << k;
    EXPECT_EQ(a.cloud.x, b.cloud.x) << k;
  }
  Scan garbage = drive.scans.back();  // what is said about it depends on what was usual before
  garbage.stamp += std::chrono::milliseconds(100);
  std::reverse(garbage.cloud.x.begin(), garbage.cloud.x.end());
  EXPECT_EQ(whole->step(garbage).quality.note, resumed->step(garbage).quality.note);
  ByteWriter end_a, end_b;
  whole->save(end_a);
  resumed->save(end_b);
  EXPECT_EQ(end_a.bytes(), end_b.bytes());
}

TEST_P(OdometryConformance, RefusesATruncatedState) {
  const auto odometry = make();
  odometry->step(test::arc(1).scans[0]);
  ByteWriter state;
  odometry->save(state);
  ByteReader half(std::string_view(state.bytes()).substr(0, state.bytes().size() - 1));
  EXPECT_THROW(make()->load(half), Error);
}

TEST_P(OdometryConformance, GivesTheSameBitsForAnyNumberOfThreads) {
  const test::Drive drive = test::arc(6);
  const auto one = make(1), four = make(4);
  for (const Scan& scan : drive.scans)
    EXPECT_EQ(one->step(scan).T_odom_base.matrix(), four->step(scan).T_odom_base.matrix());
}

INSTANTIATE_TEST_SUITE_P(FrontEnds, OdometryConformance, ::testing::ValuesIn(Registry<Odometry>::instance().names()),
                         [](const auto& tested) { return tested.param; });

TEST(OdometryRegistry, HoldsTheFrontEndsThatAreShipped) {
  EXPECT_EQ(Registry<Odometry>::instance().names(), (std::vector<std::string>{"lio", "poses", "voxel_icp"}));
}

}  // namespace
}  // namespace scslam
