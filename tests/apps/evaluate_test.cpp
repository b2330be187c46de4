#include "scslam/apps/evaluate.h"

#include <nlohmann/json.hpp>

#include "apps/session_of.h"
#include "scslam/apps/alignment.h"
#include "scslam/core/error.h"
#include "session/memory_folder.h"
#include "support/support.h"

namespace scslam::test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Poses 2 m apart along a gentle curve that climbs, heading along it.
std::vector<Pose> curve(std::size_t n) {
  std::vector<Pose> poses;
  Pose T = Pose::Identity();
  for (std::size_t i = 0; i < n; ++i) {
    poses.push_back(T);
    Vector6d step;
    step << 2, 0, 0.05, 0.001, 0, 0.01 + 0.01 * std::sin(static_cast<double>(i) / 20);
    T = retract(T, step);
  }
  return poses;
}

std::vector<Pose> scaled(std::vector<Pose> poses, double scale) {
  for (Pose& T : poses) T.translation() *= scale;
  return poses;
}

std::vector<Pose> moved(const Pose& T_a_b, std::vector<Pose> poses) {
  for (Pose& T : poses) T = T_a_b * T;
  return poses;
}

std::vector<Pose> line(std::size_t n, double step_m) {
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < n; ++i) poses.push_back(poseFromYaw(0, {step_m * static_cast<double>(i), 0, 0}));
  return poses;
}

Evaluation evaluated(const SessionParts& parts, const std::vector<Pose>& truth, const EvaluationOptions& options = {}) {
  return evaluate(sessionOf(memoryFolder() / "s", parts), untimed(truth), options);
}

const Pose kElsewhere = poseFromYaw(2.1, {450, -30, 12});

TEST(Evaluate, ShiftedAndTurnedTrajectoryHasNoError) {
  const auto truth = curve(100);
  const Evaluation e = evaluated({moved(kElsewhere, truth), moved(kElsewhere, truth)}, truth);
  EXPECT_NEAR(e.ate.rmse_m, 0, 1e-9);
  EXPECT_NEAR(e.ate.max_m, 0, 1e-9);
  EXPECT_NEAR(e.rpe.trans_percent, 0, 1e-9);
  EXPECT_THAT(e.ate.T_truth_estimate, IsNear(kElsewhere.inverse(), 1e-7, 1e-7));
  EXPECT_EQ(e.poses, 100u);
}

TEST(Evaluate, OnePercentScaleIsOnePercentRpeAndAKnownAte) {
  const auto truth = line(101, 2);  // 200 m
  const Evaluation e = evaluated({scaled(truth, 1.01), truth}, truth);
  EXPECT_NEAR(e.ate.rmse_m, 0, 1e-9);
  // About their mean, positions 2 i are off by 0.01 * 2 (i - 50): rmse 0.02 sqrt((101^2 - 1) / 12).
  EXPECT_NEAR(e.odometry_ate.rmse_m, 0.02 * std::sqrt((101.0 * 101 - 1) / 12), 1e-9);
  EXPECT_NEAR(e.odometry_ate.max_m, 1.0, 1e-9);
  EXPECT_NEAR(e.odometry_rpe.trans_percent, 1.02, 1e-9);  // segments end one pose, 2 m, after their 100 m
  EXPECT_THAT(e.odometry_rpe.lengths_m, ElementsAre(100.0));
}

TEST(Evaluate, ConstantTurnRateErrorIsItsDegreesPerMetre) {
  const auto truth = line(3001, 0.1);
  std::vector<Pose> turning;
  for (const Pose& T : truth) turning.push_back(T * poseFromYaw(0.001 * T.translation().x(), {0, 0, 0}));
  const Evaluation e = evaluated({turning, turning}, truth);
  EXPECT_NEAR(e.rpe.rot_deg_per_m, 0.001 * 180 / M_PI, 1e-4);
  EXPECT_THAT(e.rpe.lengths_m, ElementsAre(100.0, 200.0));
}

TEST(Evaluate, ShortDriveTakesShortSegmentsAndSaysSo) {
  const auto truth = line(51, 1);
  const Evaluation e = evaluated({scaled(truth, 1.02), truth}, truth);
  EXPECT_THAT(e.odometry_rpe.lengths_m, ElementsAre(10.0, 20.0, 30.0, 40.0));
  EXPECT_GT(e.odometry_rpe.trans_percent, 2.0);
  EXPECT_LT(e.odometry_rpe.trans_percent, 2.25);
  EXPECT_THAT(evaluationTable(e), HasSubstr("10 … 40 m"));
}

TEST(Evaluate, TimedTruthIsInterpolatedAtTheStampsOfTheScans) {
  const auto poses = line(50, 2);
  const Session session = sessionOf(memoryFolder() / "s", {poses, poses});
  Trajectory truth;  // every 70 ms from the third scan on
  for (int i = 0; i < 60; ++i) {
    const double t = 0.2 + 0.07 * i;
    truth.poses.push_back({stampFromSeconds(1000 + t), poseFromYaw(0, {5, 20 * t, 0})});
  }
  const Evaluation e = evaluate(session, truth);
  EXPECT_EQ(e.scans, 50u);
  EXPECT_EQ(e.poses, 42u);             // 0.2 … 4.3 s
  EXPECT_NEAR(e.ate.rmse_m, 0, 4e-6);  // 20 m/s, stamps are known to 100 ns
}

TEST(Evaluate, CountsThatDoNotAgreeAreNamed) {
  const auto poses = line(7, 1);
  try {
    evaluated({poses, poses}, line(9, 1));
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("9 poses"), HasSubstr("7 scans")));
  }
}

TEST(Evaluate, TruthOfAnotherTimeIsAnError) {
  const auto poses = line(7, 1);
  const Session session = sessionOf(memoryFolder() / "s", {poses, poses});
  Trajectory truth;
  truth.poses.push_back({stampFromSeconds(5), Pose::Identity()});
  EXPECT_THROW(evaluate(session, truth), Error);
}

TEST(Evaluate, TrueLoopsCountForPrecisionAndTheirQueriesForRecall) {
  auto truth = line(30, 1);  // out along x …
  for (int i = 29; i >= 0; --i) truth.push_back(poseFromYaw(M_PI, {static_cast<double>(i), 0.5, 0}));  // … and back
  SessionParts parts{truth, truth, {}};
  const auto relative = [&](std::size_t i, std::size_t j) -> Pose { return truth[i].inverse() * truth[j]; };
  parts.loops = {acceptedLoop(5, 54, relative(5, 54)),                                             // exact
                 acceptedLoop(6, 53, relative(6, 53) * poseFromYaw(4 * M_PI / 180, {0.9, 0, 0})),  // just true
                 acceptedLoop(7, 52, relative(7, 52) * poseFromYaw(0, {1.1, 0, 0})),               // too far
                 acceptedLoop(8, 51, relative(8, 51) * poseFromYaw(6 * M_PI / 180, {0, 0, 0}))};   // too much turned
  LoopRecord refused = parts.loops.front();
  refused.accepted = false;
  parts.loops.push_back(refused);
  const Evaluation e = evaluated(parts, truth);
  const LoopFigures& f = e.loops;
  EXPECT_EQ(f.candidates, 5u);
  EXPECT_EQ(f.accepted, 4u);
  EXPECT_EQ(f.true_accepted, 2u);
  EXPECT_EQ(f.false_accepted, 2u);
  EXPECT_THAT(evaluationTable(e), AllOf(HasSubstr("52 -> 7 is wrong by 1.10 m, 0.0 deg"),
                                        HasSubstr("51 -> 8 is wrong by 0.00 m, 6.0 deg")));
  const auto listed = nlohmann::json::parse(evaluationJson(e))["loops"]["false"];
  ASSERT_EQ(listed.size(), 2u);
  EXPECT_EQ(listed[0]["match"], 7);
  EXPECT_DOUBLE_EQ(*f.precision, 0.5);
  // Counted plainly: on the way back at x = i, keyframe j of the way out is near and long enough ago.
  std::size_t revisits = 0;
  for (int i = 29; i >= 0; --i) {
    bool near = false;
    for (int j = 0; j < 30; ++j) near |= std::hypot(i - j, 0.5) <= 3 && (29 - j) + 0.5 + (29 - i) >= 15;
    revisits += near;
  }
  EXPECT_EQ(f.revisits, revisits);
  EXPECT_GT(revisits, 15u);
  EXPECT_DOUBLE_EQ(*f.recall, 2.0 / static_cast<double>(revisits));
}

TEST(Evaluate, NothingToCountIsNullInJson) {
  const auto poses = line(5, 1);
  const auto json = nlohmann::json::parse(evaluationJson(evaluated({poses, poses}, poses)));
  EXPECT_TRUE(json["loops"]["precision"].is_null());
  EXPECT_TRUE(json["loops"]["recall"].is_null());
  for (const char* key : {"ate_rmse_m", "ate_max_m", "odometry_ate_rmse_m", "rpe_trans_percent",
                          "odometry_rpe_trans_percent", "rpe_rot_deg_per_m", "poses"})
    EXPECT_TRUE(json["trajectory"][key].is_number()) << key;
  EXPECT_TRUE(json["trajectory"]["alignment"].is_string());
}

TEST(Evaluate, DrivesOfOneOrTwoPosesAndStandingStillAreFine) {
  for (const std::size_t n : {1u, 2u}) {
    const auto truth = curve(n);
    const Evaluation e = evaluated({moved(kElsewhere, truth), moved(kElsewhere, truth)}, truth);
    EXPECT_NEAR(e.ate.rmse_m, 0, 1e-9);
    EXPECT_EQ(e.rpe.segments, n == 1 ? 0u : 2u);  // a step of a little over 2 m: segments of 1 and 2 m
    EXPECT_TRUE(std::isfinite(e.rpe.trans_percent));
  }
  const std::vector<Pose> standing(10, kElsewhere);
  const Evaluation e = evaluated({std::vector<Pose>(10, Pose::Identity()), standing}, standing);
  EXPECT_NEAR(e.odometry_ate.rmse_m, 0, 1e-9);
  EXPECT_THAT(e.odometry_ate.T_truth_estimate, IsNear(kElsewhere, 1e-7, 1e-6));
}

TEST(Alignment, OrientationDecidesWhatPositionsOnALineLeaveOpen) {
  const auto poses = line(20, 1);
  const Pose T = kElsewhere * Pose(Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitX()));
  EXPECT_THAT(alignPoses(moved(T, poses), poses), IsNear(T, 1e-6, 1e-4));
}

TEST(Alignment, NoiseAcrossAStraightDriveDoesNotRollWhatHasALever) {
  const auto poses = line(20, 1);
  auto seen = moved(kElsewhere, poses);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const double noise = i % 2 == 0 ? 0.01 : -0.01;
    seen[i].translation() += kElsewhere.linear() * Eigen::Vector3d(0, noise, 0);
    seen[i].linear() = seen[i].linear() * Eigen::AngleAxisd(noise / 10, Eigen::Vector3d::UnitX());
  }
  auto other_noise = poses;
  for (std::size_t i = 0; i < poses.size(); ++i) other_noise[i].translation().z() += i % 2 == 0 ? 0.01 : -0.01;
  EXPECT_GT(local(kElsewhere, alignPoses(seen, other_noise)).tail<3>().norm(), 0.1);
  EXPECT_THAT(alignPoses(seen, other_noise, kOrientationLever_m), IsNear(kElsewhere, 0.01, 0.02));
}

TEST(Alignment, WrongOrientationsDoNotBendIt) {
  const auto poses = curve(60);
  auto seen = moved(kElsewhere, poses);
  for (Pose& pose : seen) pose = pose * poseFromYaw(1.0, {0, 0, 0});  // a camera that looks elsewhere
  EXPECT_THAT(alignPoses(seen, poses), IsNear(kElsewhere, 1e-5, 1e-5));
}

TEST(Alignment, NeverMirrors) {
  auto poses = curve(40), mirrored = poses;
  for (Pose& T : mirrored) T.translation().y() *= -1;
  EXPECT_NEAR(alignPoses(mirrored, poses).linear().determinant(), 1, 1e-9);
}

TEST(Evaluate, PlanarDataIsJudgedInXAndYWhereHeightsAndTiltsDoNotCount) {
  std::vector<Pose> flat, truth;
  for (int i = 0; i < 80; ++i) {
    flat.push_back(poseFromYaw(0.02 * i, {2.0 * i, 0.01 * i * i, 0}));
    // The ground waves by a decimetre, and the car pitches with it.
    truth.push_back(flat.back());
    truth.back().translation().z() = 0.1 * std::sin(i);
    truth.back() = truth.back() * Eigen::AngleAxisd(0.02 * std::cos(i), Eigen::Vector3d::UnitY());
  }
  const AbsoluteError e = absoluteError(truth, flat);
  EXPECT_NEAR(e.rmse_m, 0.07, 0.005);
  EXPECT_LT(e.level_rmse_m, 0.003);
  EXPECT_GT(relativeError(truth, flat).trans_percent, 1);
  EXPECT_LT(levelRelativeError(truth, flat).trans_percent, 0.01);
  // An error in the plane counts in full.
  EXPECT_NEAR(levelRelativeError(flat, scaled(flat, 1.02)).trans_percent, 2, 0.05);
}

TEST(Evaluate, RealOdometryHasTheErrorThatAnIndependentProgramFinds) {
  SCSLAM_NEEDS_DATA(folder, "kitti00_kf000-039");
  const auto posesOf = [&](const char* name) {
    std::vector<Pose> poses;
    for (const auto& pose : readTrajectory(folder / name).poses) poses.push_back(pose.T);
    return poses;
  };
  const auto truth = posesOf("poses_gt.txt"), odometry = posesOf("poses_laser_odom.txt");
  const Evaluation e = evaluated({odometry, truth}, truth);
  EXPECT_NEAR(e.odometry_ate.rmse_m, 0.185384035, 1e-6);
  EXPECT_NEAR(e.ate.rmse_m, 0, 1e-9);
}

}  // namespace
}  // namespace scslam::test
