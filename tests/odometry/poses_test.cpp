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

/// Positions as in the file, unless `sets` say otherwise.
std::unique_ptr<Odometry> posesFrom(const std::string& file, const std::vector<std::string>& sets = {}) {
  const auto& entry = Registry<Odometry>::instance().find("poses");
  const auto params = entry.defaults();
  setParam(*params, "file=" + file);
  setParam(*params, "origin=file");
  for (const auto& set : sets) setParam(*params, set);
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

/// A smooth curve that every rate samples the same way: x = 2 t, turning by 0.1 rad/s. @param t [s] after 1000 s.
Pose onTheWay(double t) { return poseFromYaw(0.1 * t, {2 * t, 0, 0.5}); }

/// As another program would write it: `rate` Hz from 999.9 s on for two seconds, four decimals.
std::string foreignFile(double rate, double clock_s = 0, const Pose& T_world_odom = Pose::Identity(),
                        const Pose& T_base_frame = Pose::Identity()) {
  std::string text = "# time x y z qx qy qz qw\n";
  for (int i = 0; i < 2 * rate; ++i) {
    const double t = std::round((-0.1 + i / rate) * 1e4) / 1e4;
    const Pose T = T_world_odom * onTheWay(t) * T_base_frame;
    const Eigen::Quaterniond q(T.linear());
    text += fmt::format("{:.4f} {:.4f} {:.4f} {:.4f} {:.6f} {:.6f} {:.6f} {:.6f}\n", 1000 + clock_s + t,
                        T.translation().x(), T.translation().y(), T.translation().z(), q.x(), q.y(), q.z(), q.w());
  }
  return write("foreign.tum", text);
}

TEST(Poses, TakesAnyRateAndFourDecimals) {
  for (const double rate : {3.0, 10.0, 37.0, 200.0}) {
    const auto odometry = posesFrom(foreignFile(rate));
    for (std::size_t k = 0; k < 10; ++k)
      EXPECT_THAT(odometry->step(test::scanAt(k, Pose::Identity(), 100)).T_odom_base,
                  IsNear(onTheWay(0.1 * static_cast<double>(k)), 0.001, 0.01))
          << rate << " Hz, scan " << k;
  }
}

TEST(Poses, ShiftsAnotherClock) {
  const auto odometry = posesFrom(foreignFile(20, -998.5), {"time_offset_s=998.5"});
  EXPECT_THAT(odometry->step(test::scanAt(3, Pose::Identity(), 100)).T_odom_base, IsNear(onTheWay(0.3), 0.001, 0.01));
  const auto unshifted = posesFrom(foreignFile(20, -998.5));
  EXPECT_THAT([&] { unshifted->step(test::scanAt(0, Pose::Identity(), 100)); },
              ThrowsMessage<Error>(HasSubstr("time_offset_s")));
  EXPECT_THAT([&] { posesFrom(write("k.txt", formatKitti({Pose::Identity()})), {"time_offset_s=1"}); },
              ThrowsMessage<Error>(HasSubstr("has no times")));
}

TEST(Poses, CountsPositionsFromTheFirstPoseAndKeepsTheAttitude) {
  const Pose T_utm_odom = poseFromYaw(2.0, {444000, 4'920'000, 120});
  const auto odometry = posesFrom(foreignFile(20, 0, T_utm_odom), {"origin=first"});
  Pose first = T_utm_odom * onTheWay(0);
  for (std::size_t k = 0; k < 5; ++k) {
    Pose expected = T_utm_odom * onTheWay(0.1 * static_cast<double>(k));
    expected.translation() -= first.translation();
    EXPECT_THAT(odometry->step(test::scanAt(k, Pose::Identity(), 100)).T_odom_base, IsNear(expected, 0.001, 0.01));
  }
}

TEST(Poses, AResumedRunKeepsItsOrigin) {
  const std::string file = foreignFile(20, 0, poseFromYaw(0, {1000, 0, 0}));
  const auto whole = posesFrom(file, {"origin=first"});
  whole->step(test::scanAt(0, Pose::Identity(), 100));
  ByteWriter state;
  whole->save(state);
  const auto resumed = posesFrom(file, {"origin=first"});
  ByteReader reader(state.bytes());
  resumed->load(reader);
  const Scan next = test::scanAt(1, Pose::Identity(), 100);
  EXPECT_EQ(resumed->step(next).T_odom_base.matrix(), whole->step(next).T_odom_base.matrix());
}

TEST(Poses, MovesPosesOfTheSensorToTheBase) {
  const auto odometry = posesFrom(foreignFile(20, 0, Pose::Identity(), test::T_base_sensor()), {"frame=sensor"});
  EXPECT_THAT(odometry->step(test::scanAt(2, Pose::Identity(), 100)).T_odom_base, IsNear(onTheWay(0.2), 0.001, 0.01));
}

TEST(Poses, ReadsAnEurocTable) {
  const auto table = [](std::int64_t begin_ns) {
    std::string text = "#timestamp [ns],p_x,p_y,p_z,q_w,q_x,q_y,q_z,v_x,v_y,v_z\n";
    for (int i = 0; i < 5; ++i) {
      const Pose T = onTheWay(0.1 * i);
      const Eigen::Quaterniond q(T.linear());
      text += fmt::format("{},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},2,0,0\n", begin_ns + 100'000'000LL * i,
                          T.translation().x(), T.translation().y(), T.translation().z(), q.w(), q.x(), q.y(), q.z());
    }
    return text;
  };
  const Trajectory read = readTrajectory(write("data.csv", table(1'403'636'579'763'555'584)));
  ASSERT_EQ(read.poses.size(), 5u);
  EXPECT_EQ(formatStamp(read.poses[0].stamp), "1403636579.763555500") << "to the tick of 100 ns";
  EXPECT_NEAR(secondsBetween(read.poses[0].stamp, read.poses[4].stamp), 0.4, 1e-9);
  EXPECT_THAT(read.poses[3].T, IsNear(onTheWay(0.3), 1e-6, 1e-4));
  // Thirteen digits may be milliseconds as well: refused rather than guessed at.
  EXPECT_THAT([&] { readTrajectory(write("early.csv", table(1'000'000'000'000))); },
              ThrowsMessage<Error>(HasSubstr("EuRoC")));
}

TEST(Poses, RefusesToGuessAcrossAGap) {
  std::string text = formatTum({{stampFromSeconds(999), onTheWay(-1)}, {stampFromSeconds(1004), onTheWay(4)}});
  const std::string file = write("gap.tum", text);
  EXPECT_THAT([&] { posesFrom(file)->step(test::scanAt(0, Pose::Identity(), 100)); },
              ThrowsMessage<Error>(HasSubstr("max_gap_s")));
  EXPECT_THAT(posesFrom(file, {"max_gap_s=10"})->step(test::scanAt(0, Pose::Identity(), 100)).T_odom_base,
              IsNear(onTheWay(0), 0.01, 0.01));
}

TEST(Poses, CompensatesTheMotionWithinASweep) {
  const auto seen = [](const std::string& file, std::size_t index) {
    Scan scan = test::scanAt(index, Pose::Identity(), 100);
    scan.T_base_sensor = Pose::Identity();
    scan.cloud = {};
    scan.cloud.push(10, 0, 0), scan.cloud.push(10, 0, 0);
    scan.cloud.dt = {0.0f, 0.1f};
    scan.T_odom_base = onTheWay(0.1 * static_cast<double>(index));
    return std::pair(scan, posesFrom(file));
  };
  const Pose T_begin_end = onTheWay(0.1).inverse() * onTheWay(0.2);
  const Eigen::Vector3f expected = (T_begin_end * Eigen::Vector3d(10, 0, 0)).cast<float>();
  {  // the file knows the end of the sweep, even for the first scan
    auto [scan, odometry] = seen(foreignFile(100), 1);
    const Cloud cloud = odometry->step(scan).cloud;
    EXPECT_EQ(cloud.point(0), Eigen::Vector3f(10, 0, 0));
    EXPECT_LT((cloud.point(1) - expected).norm(), 0.003);
  }
  {  // the recording only knows how it moved since the last scan
    auto [scan, odometry] = seen("", 1);
    auto [before, unused] = seen("", 0);
    EXPECT_EQ(odometry->step(before).cloud.point(1), Eigen::Vector3f(10, 0, 0));
    EXPECT_LT((odometry->step(scan).cloud.point(1) - expected).norm(), 0.003);
  }
  {  // what is compensated already stays
    auto [scan, odometry] = seen(foreignFile(100), 1);
    scan.deskewed = true;
    EXPECT_EQ(odometry->step(scan).cloud.point(1), Eigen::Vector3f(10, 0, 0));
  }
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
