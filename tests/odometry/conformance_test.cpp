// What every odometry front-end promises (odometry/odometry.h), checked on each that is registered.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>

#include "odometry/radar_drive.h"
#include "scslam/odometry/odometry.h"

namespace scslam {
namespace {

using test::IsNear;

class OdometryConformance : public ::testing::TestWithParam<std::string> {
 protected:
  static std::unique_ptr<Odometry> make(int threads = 1) {
    auto odometry = Registry<Odometry>::instance().create(GetParam(), test::context(threads));
    odometry->begin(std::nullopt, Pose::Identity());
    return odometry;
  }

  /// Front-ends for radars are given sweeps of one.
  static bool radar() { return GetParam().starts_with("radar_"); }
  static Scan scanAt(std::size_t index, const Pose& T_world_base) {
    return radar() ? test::radarAt(index, T_world_base) : test::spunAt(index, T_world_base);
  }

  /// The scans, with recorded odometry only for a front-end that knows of nothing else.
  static test::Drive arc(std::size_t steps) {
    std::vector<Pose> T_world_base{poseFromYaw(0.2, {-4, -1, 0})};
    while (T_world_base.size() < steps)
      T_world_base.push_back(T_world_base.back() * poseFromYaw(0.035, {0.15, 0.01, 0}));
    return along(T_world_base);
  }
  static test::Drive along(const std::vector<Pose>& T_world_base) {
    test::Drive drive;
    for (std::size_t k = 0; k < T_world_base.size(); ++k) {
      drive.T_world_base.push_back(T_world_base[k]);
      drive.scans.push_back(scanAt(k, T_world_base[k]));
    }
    return withRecorded(std::move(drive));
  }
  static test::Drive withRecorded(test::Drive drive) {
    if (needsRecorded())
      for (std::size_t k = 0; k < drive.scans.size(); ++k) drive.scans[k].T_odom_base = drive.T_world_base[k];
    return drive;
  }
  static bool needsRecorded() {
    const auto odometry = make();
    try {
      odometry->step(scanAt(0, Pose::Identity()));
    } catch (const Error&) {
      return true;
    }
    return false;
  }

  /// Steps through the drive; each pose within these limits of the truth.
  static void follows(const test::Drive& drive, double trans_m, double rot_deg) {
    const auto odometry = make();
    Pose T_odom_world;
    for (std::size_t k = 0; k < drive.scans.size(); ++k) {
      const OdometryStep step = odometry->step(drive.scans[k]);
      EXPECT_TRUE(step.quality.ok) << k << ": " << step.quality.note;
      if (k == 0) T_odom_world = step.T_odom_base * drive.T_world_base[0].inverse();
      EXPECT_THAT(T_odom_world.inverse() * step.T_odom_base, IsNear(drive.T_world_base[k], trans_m, rot_deg)) << k;
    }
  }
};

TEST_P(OdometryConformance, FollowsADriveThroughARoom) { follows(arc(25), 0.02, 0.2); }

TEST_P(OdometryConformance, StandingStillDoesNotDrift) {
  follows(along(std::vector<Pose>(20, poseFromYaw(0.3, {1, 1, 0}))), 0.006, 0.06);
}

TEST_P(OdometryConformance, FollowsATurnInPlace) {
  std::vector<Pose> poses;
  for (int k = 0; k < 25; ++k) poses.push_back(poseFromYaw(0.09 * k, {-1, 0.5, 0}));
  follows(along(poses), 0.03, 0.3);
}

TEST_P(OdometryConformance, TakesStampsInAnySpacing) {
  test::Drive drive = arc(24);
  const double steps_s[] = {0.1, 0.1, 0.03, 0.25, 1.0, 0.0, 0.1, 3600.0};
  double t = 50;
  for (std::size_t k = 0; k < drive.scans.size(); ++k) {
    drive.scans[k].stamp = stampFromSeconds(t);
    t += steps_s[k % std::size(steps_s)];
  }
  follows(drive, 0.03, 0.3);
}

TEST_P(OdometryConformance, FirstStepHasZeroCovarianceAndLaterOnesAreProper) {
  const test::Drive drive = arc(4);
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
  Scan scan = arc(1).scans[0];
  scan.cloud.x[7] = std::numeric_limits<float>::quiet_NaN();
  const Eigen::Vector3d expected = scan.T_base_sensor * scan.cloud.point(0).cast<double>();
  const OdometryStep step = make()->step(scan);
  ASSERT_GT(step.cloud.size(), radar() ? 500u : 1000u);
  EXPECT_LT(step.cloud.size(), scan.cloud.size());
  EXPECT_EQ(step.cloud.intensity.size(), step.cloud.size());
  EXPECT_LT((step.cloud.point(0).cast<double>() - expected).norm(), 1e-4);
  for (std::size_t i = 0; i < step.cloud.size(); ++i) ASSERT_TRUE(step.cloud.point(i).allFinite());
}

TEST_P(OdometryConformance, UselessScansAreNotOkAndNeverThrow) {
  const test::Drive drive = arc(6);
  Scan empty = drive.scans[2], nans = drive.scans[3], one = drive.scans[4], far = drive.scans[4];
  empty.cloud = {};
  nans.cloud.x.assign(nans.cloud.size(), std::numeric_limits<float>::quiet_NaN());
  one.cloud = {};
  one.cloud.push(3, 2, 1);
  for (auto* axis : {&far.cloud.x, &far.cloud.y, &far.cloud.z})
    for (float& value : *axis) value *= 1e4f;
  const auto odometry = make();
  // A front-end that only looks up poses needs no more than a point.
  const std::vector<Scan> useless = needsRecorded() ? std::vector{empty, nans} : std::vector{empty, nans, one, far};
  for (const Scan& scan : useless) EXPECT_FALSE(make()->step(scan).quality.ok) << "as the first scan";
  odometry->step(drive.scans[0]);
  odometry->step(drive.scans[1]);
  for (const Scan& scan : useless) {
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
  const test::Drive drive = arc(14);
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
  odometry->step(arc(1).scans[0]);
  ByteWriter state;
  odometry->save(state);
  ByteReader half(std::string_view(state.bytes()).substr(0, state.bytes().size() - 1));
  EXPECT_THROW(make()->load(half), Error);
}

TEST_P(OdometryConformance, GivesTheSameBitsForAnyNumberOfThreads) {
  const test::Drive drive = arc(6);
  const auto one = make(1), two = make(2), four = make(4);
  for (const Scan& scan : drive.scans) {
    const OdometryStep a = one->step(scan), b = two->step(scan), c = four->step(scan);
    EXPECT_EQ(a.T_odom_base.matrix(), b.T_odom_base.matrix());
    EXPECT_EQ(a.T_odom_base.matrix(), c.T_odom_base.matrix());
    EXPECT_EQ(a.covariance, b.covariance);
    EXPECT_EQ(a.cloud.x, b.cloud.x);
  }
  ByteWriter state_one, state_two;
  one->save(state_one);
  two->save(state_two);
  EXPECT_EQ(state_one.bytes(), state_two.bytes());
}

// The robot slows down to a stop and turns while it sees nothing: its last velocity is no help.
TEST_P(OdometryConformance, ComesBackAfterFiveSecondsOfBlindness) {
  test::Drive drive = arc(12);
  Pose T = drive.T_world_base.back();
  for (std::size_t k = 12; k < 62; ++k) {
    if (k < 20) T = T * poseFromYaw(0.06, {0.05, 0, 0});
    Scan blind = scanAt(k, T);
    blind.cloud = {};
    drive.scans.push_back(blind);
    drive.T_world_base.push_back(T);
  }
  for (std::size_t k = 62; k < 68; ++k) {
    drive.scans.push_back(scanAt(k, T));
    drive.T_world_base.push_back(T);
    T = T * poseFromYaw(0.01, {0.1, 0, 0});
  }
  drive = withRecorded(std::move(drive));
  const auto odometry = make();
  OdometryStep step;
  Pose T_odom_world;  // where odom lies in the world is the front-end's own
  for (std::size_t k = 0; k < drive.scans.size(); ++k) {
    step = odometry->step(drive.scans[k]);
    if (k == 0) T_odom_world = step.T_odom_base * drive.T_world_base[0].inverse();
    EXPECT_EQ(step.quality.ok, k < 12 || k >= 62) << k << ": " << step.quality.note;
    if (!step.quality.ok && !needsRecorded()) {
      EXPECT_GT(step.covariance(0, 0), 0.05 * 0.05) << k << ": nothing was seen";
    }
  }
  EXPECT_THAT(T_odom_world.inverse() * step.T_odom_base, IsNear(drive.T_world_base.back(), 0.03, 0.3));
}

INSTANTIATE_TEST_SUITE_P(FrontEnds, OdometryConformance, ::testing::ValuesIn(Registry<Odometry>::instance().names()),
                         [](const auto& tested) { return tested.param; });

}  // namespace
}  // namespace scslam
