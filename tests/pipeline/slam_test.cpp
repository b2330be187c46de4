// tests/pipeline/slam_test.cpp: the whole way on made-up drives whose truth is known.
#include <atomic>

#include "scslam/apps/evaluate.h"
#include "scslam/apps/run_job.h"
#include "scslam/graph/factor_error.h"
#include "scslam/pipeline/factors.h"
#include "scslam/session/session.h"
#include "support/support.h"
#include "support/town.h"

namespace scslam {
namespace {

using test::contents;
using test::IsNear;

struct Drive {
  std::filesystem::path folder;
  std::vector<Pose> truth;
};

/// Made once per process: scans are the slow part.
const Drive& blockDrive() {
  static const Drive drive = [] {
    Drive d{std::filesystem::path(SCSLAM_TEST_TMP) / "block-drive", test::aroundTheBlock()};
    std::filesystem::remove_all(d.folder);
    test::writeKittiDrive(d.folder, test::Town(), d.truth, test::withDrift(d.truth));
    return d;
  }();
  return drive;
}

RunOptions externalOdometry(const Drive& drive, const std::filesystem::path& output) {
  RunOptions options;
  options.input = drive.folder.string();
  options.output = output;
  options.quiet = true;
  options.sets = {"odometry.frontend=poses",
                  "odometry.poses.file=\"" + (drive.folder / "odometry.txt").string() + "\""};
  return options;
}

TEST(Slam, ClosesTheBlockAndTakesTheDriftOut) {
  const auto folder = test::freshFolder();
  const RunSummary summary = runJob(externalOdometry(blockDrive(), folder / "s"), test::context(2));
  EXPECT_EQ(summary.end, SessionEnd::kDone);
  EXPECT_EQ(summary.counts.scans, blockDrive().truth.size());
  EXPECT_GE(summary.counts.loops, 5u);
  const Evaluation e = evaluate(Session::open(folder / "s"), *summary.ground_truth);
  EXPECT_EQ(e.loops.false_accepted, 0u);
  EXPECT_GT(e.odometry_ate.rmse_m, 1.0);
  EXPECT_LT(e.ate.rmse_m, 0.25);
}

TEST(Slam, ClosesALoopDrivenBackwards) {
  const auto folder = test::freshFolder();
  const Drive drive{folder / "in", test::outAndBack()};
  test::writeKittiDrive(drive.folder, test::Town(3), drive.truth, test::withDrift(drive.truth));
  const RunSummary summary = runJob(externalOdometry(drive, folder / "s"), test::context());
  EXPECT_GE(summary.counts.loops, 5u);
  const Evaluation e = evaluate(Session::open(folder / "s"), *summary.ground_truth);
  EXPECT_EQ(e.loops.false_accepted, 0u);
  EXPECT_LT(e.ate.rmse_m, 0.5 * e.odometry_ate.rmse_m);
}

TEST(Slam, OwnOdometryMapsTheBlock) {
  const auto folder = test::freshFolder();
  const Drive drive{folder / "in", test::aroundTheBlock(1.0)};
  test::writeKittiDrive(drive.folder, test::Town(), drive.truth, drive.truth, 25000);
  RunOptions options = externalOdometry(drive, folder / "s");
  options.sets = {"odometry.voxel_icp.use_recorded_odometry=false"};
  const RunSummary summary = runJob(options, test::context(2));
  EXPECT_EQ(summary.counts.lost_scans, 0u);
  EXPECT_GE(summary.counts.loops, 3u);
  const Evaluation e = evaluate(Session::open(folder / "s"), *summary.ground_truth);
  EXPECT_LT(e.ate.rmse_m, 0.3);
  EXPECT_EQ(e.loops.false_accepted, 0u);
}

TEST(Slam, SameBytesForAnyNumberOfThreads) {
  const auto folder = test::freshFolder();
  for (const bool own : {false, true}) {
    RunOptions options = externalOdometry(blockDrive(), folder / "one");
    if (own) options.sets.clear();
    options.overwrite = true;
    options.max = 30;
    runJob(options, test::context(1));
    options.output = folder / "two";
    runJob(options, test::context(2));
    EXPECT_EQ(contents(folder / "one"), contents(folder / "two")) << (own ? "voxel_icp" : "poses");
  }
}

TEST(Slam, AStoppedRunIsAWholeSessionAndGoesOnToTheSameBytes) {
  const auto folder = test::freshFolder();
  RunOptions options = externalOdometry(blockDrive(), folder / "undisturbed");
  options.sets.push_back("session.checkpoint_every=7");
  options.max = 50;
  runJob(options, test::context());
  std::atomic<bool> stop{true};  // before the first scan already
  options.output = folder / "stopped";
  options.stop = &stop;
  EXPECT_EQ(runJob(options, test::context()).end, SessionEnd::kStopped);
  EXPECT_TRUE(Session::open(folder / "stopped").complete());
  options.stop = nullptr;
  options.resume = true;
  EXPECT_EQ(runJob(options, test::context()).end, SessionEnd::kDone);
  EXPECT_EQ(contents(folder / "stopped"), contents(folder / "undisturbed"));
}

TEST(Factors, FloorsLimitTrustAndSingularInformationStaysSingular) {
  Matrix6d information = Matrix6d::Identity() * 1e9;
  information.row(1).setZero();
  information.col(1).setZero();
  const Matrix6d limited = withFloor(information, 0.1, 1.0);
  EXPECT_NEAR(limited(0, 0), 100, 0.1);
  EXPECT_EQ(limited(1, 1), 0);
  EXPECT_NEAR(limited(5, 5), std::pow(180 / M_PI, 2), 1);
  const Matrix6d weak = Matrix6d::Identity() * 1e-3;
  EXPECT_LT((withFloor(weak, 0.1, 1.0) - weak).norm(), 1e-6);
}

TEST(Factors, ALoopWithManyOutliersWeighsLess) {
  LoopRecord record;
  record.information = Matrix6d::Identity() * 1e9;
  GraphParams params;
  params.loop_floor_m = 0.1, params.loop_outliers = 0.05;
  for (const double outliers : {0.0, 0.05}) {
    record.inlier_ratio = 1 - outliers;
    EXPECT_NEAR(loopInformation(record, params)(0, 0), 100, 0.1) << outliers;
  }
  record.inlier_ratio = 0.9;  // twice as many: four times the sigma
  EXPECT_NEAR(loopInformation(record, params)(0, 0), 100.0 / 16, 0.01);
  EXPECT_EQ(loopFactor(record, params).information, loopInformation(record, params));
}

TEST(Factors, ASyntheticLoopClosesToZero) {
  // X_match^-1 X_query measured exactly: the loop factor of perfect poses has no residual, in any place and heading.
  const Pose X_match = poseFromYaw(2.5, {40, -3, 1}), X_query = poseFromYaw(-0.6, {41, -2, 1.2});
  LoopRecord record;
  record.match = 0, record.query = 1, record.accepted = true;
  record.T_match_query = X_match.inverse() * X_query;
  record.information = Matrix6d::Identity() * 100;
  PoseGraph graph;
  graph.poses = {X_match, X_query};
  graph.factors = {loopFactor(record, GraphParams{})};
  EXPECT_NEAR(graphChi2(graph), 0, 1e-20);
}

}  // namespace
}  // namespace scslam
