#include "scslam/registration/loop_gates.h"

#include <gmock/gmock.h>

namespace scslam {
namespace {

using ::testing::HasSubstr;

RegistrationResult good() {
  RegistrationResult result;
  result.points = 500;
  result.converged = true;
  result.inlier_ratio = result.overlap = result.explained = 0.9;
  result.rmse_m = 0.05;
  return result;
}

TEST(LoopGates, PassAGoodResultAndNameWhatIsWrongWithABadOne) {
  LoopGateParams params;
  params.min_overlap = params.min_explained = 0.5;
  params.min_inlier_ratio = 0.4;
  params.max_rmse_m = 0.25;
  params.max_degenerate_axes = 2;
  EXPECT_EQ(refusal(good(), params), "");
  RegistrationResult r = good();
  r.points = 29, params.min_points = 30;
  EXPECT_THAT(refusal(r, params), HasSubstr("29 points < 30"));
  r = good(), r.T_target_source = poseFromYaw(1, {0, 20.1, 0}), params.max_apart_m = 20;
  EXPECT_THAT(refusal(r, params), HasSubstr("20.1 m apart > 20.0 m"));
  r = good(), r.converged = false;
  EXPECT_THAT(refusal(r, params), HasSubstr("converge"));
  r = good(), r.overlap = 0.31;
  EXPECT_THAT(refusal(r, params), HasSubstr("overlap 0.31 < 0.50"));
  r = good(), r.explained = 0.44;
  EXPECT_THAT(refusal(r, params), HasSubstr("explained 0.44 of the scan < 0.50"));
  r = good(), r.inlier_ratio = 0.2;
  EXPECT_THAT(refusal(r, params), HasSubstr("inliers 0.20"));
  r = good(), r.rmse_m = 0.4;
  EXPECT_THAT(refusal(r, params), HasSubstr("rmse 0.400 m"));
  r = good(), r.degenerate_axes = 3;
  EXPECT_THAT(refusal(r, params), HasSubstr("3 directions"));
}

TEST(LoopGates, SayWhoSeesThroughWhoseWalls) {
  LoopGateParams params;
  params.max_seen_through = 0.05;
  EXPECT_EQ(refusal(FreeSpace{1, 0.05, 0.05}, params), "");
  EXPECT_EQ(refusal(FreeSpace{1, 0.14, 0}, params),
            "free space: the scan sees through 14.0 % of the submap's walls > 5.0 %");
  EXPECT_EQ(refusal(FreeSpace{1, 0, 0.073}, params),
            "free space: the submap sees through 7.3 % of the scan's walls > 5.0 %");
  params.min_target_overlap = 0.8;
  EXPECT_THAT(refusal(FreeSpace{0.31, 0, 0}, params), HasSubstr("0.31 of the submap's surface"));
}

TEST(LoopGates, OdometryDisagreementIsCountedInSigmas) {
  LoopGateParams params;
  params.odometry_sigma_per_m = 0.01;
  OdometryPrediction predicted;
  predicted.travelled_m = 100;
  const Pose measured = poseFromYaw(0, {3.0, 0, 0});
  // 100 m at 1 % are 1 m of sigma: 3 m off are 3 sigma.
  EXPECT_NEAR(odometryDisagreement(measured, predicted, false, params), 9.0, 0.01);
  EXPECT_NEAR(odometryDisagreement(measured, predicted, true, params), 9.0, 0.01);
  // Planar data says nothing about height.
  const Pose higher = poseFromYaw(0, {0, 0, 50});
  EXPECT_NEAR(odometryDisagreement(higher, predicted, true, params), 0.0, 1e-9);
  // The path's own covariance widens the gate.
  predicted.path_covariance = 8 * Matrix6d::Identity();
  EXPECT_NEAR(odometryDisagreement(measured, predicted, false, params), 1.0, 0.01);
}

TEST(LoopGates, OnlyWhereOdometryLostTrackIsAFarPlacePlausible) {
  OdometryPrediction predicted;
  predicted.travelled_m = 10;
  predicted.T_match_query = poseFromYaw(0, {80, 0, 0});
  EXPECT_FALSE(implausible(predicted, LoopGateParams()).empty());
  predicted.path_covariance = 900 * Matrix6d::Identity();  // a tunnel: not fixed, but followed
  EXPECT_FALSE(implausible(predicted, LoopGateParams()).empty());
  predicted.followed = false;
  EXPECT_TRUE(implausible(predicted, LoopGateParams()).empty());
}

TEST(LoopGates, WhatTheOverlapLeavesOpenIsOdometrys) {
  RegistrationResult corridor = good();  // along x nothing is fixed
  corridor.degenerate_axes = 1;
  corridor.unfixed(0, 0) = 1;
  corridor.T_target_source = poseFromYaw(0, {4.0, 0.2, 0});
  OdometryPrediction predicted;
  predicted.T_match_query = poseFromYaw(0, {1.0, 0.1, 0});
  predicted.travelled_m = 50;
  EXPECT_NEAR(completed(corridor, predicted).translation().x(), 1.0, 1e-9);
  EXPECT_NEAR(completed(corridor, predicted).translation().y(), 0.2, 1e-9);
  const auto refused = [&] { return chosenByOdometry(corridor, predicted, false, {}).refusal; };
  EXPECT_EQ(refused(), "") << "3 m apart where nothing is known is no contradiction";
  corridor.degenerate_axes = 0;
  EXPECT_THAT(refused(), HasSubstr("odometry disagrees: chi2"));
  // Far along the corridor the submap says nothing.
  corridor.degenerate_axes = 1;
  predicted.T_match_query = poseFromYaw(0, {30, 0.1, 0});
  EXPECT_THAT(refused(), HasSubstr("1 directions unfixed, and odometry places it"));
}

TEST(LoopGates, TwoPosesThatFitAlikeAreAmbiguousUnlessOdometryKnows) {
  RegistrationResult result = good(), turned = good();
  turned.T_target_source = poseFromYaw(M_PI, {0.5, 0, 0});
  turned.fit = 0.98;
  result.rivals = {turned};
  OdometryPrediction predicted;
  predicted.travelled_m = 10;
  EXPECT_EQ(chosenByOdometry(result, predicted, false, {}).refusal, "") << "after 10 m odometry knows front from back";
  std::swap(result.T_target_source, result.rivals.front().T_target_source);
  const Choice chosen = chosenByOdometry(result, predicted, false, {});
  EXPECT_EQ(chosen.refusal, "");
  EXPECT_EQ(chosen.result.T_target_source.matrix(), Pose::Identity().matrix()) << "and picks the one it allows";
  predicted.path_covariance = 10 * Matrix6d::Identity();
  EXPECT_EQ(chosenByOdometry(result, predicted, false, {}).refusal,
            "ambiguous: a pose 0.5 m and 180 deg away fits 98 % as well");
  result.rivals.front().fit = 0.7;
  EXPECT_EQ(chosenByOdometry(result, predicted, false, {}).refusal, "");
}

TEST(LoopGates, ImplausibleCandidatesAreNamedBeforeAnyWork) {
  OdometryPrediction predicted;
  predicted.T_match_query = poseFromYaw(0, {40, 0, 0});
  predicted.travelled_m = 100;
  EXPECT_EQ(implausible(predicted, {}), "odometry places it 40.0 m away, at most 14.1 m is plausible");
  predicted.travelled_m = 1000;
  EXPECT_EQ(implausible(predicted, {}), "");
}

}  // namespace
}  // namespace scslam
