#include "scslam/registration/loop_gates.h"

#include <gmock/gmock.h>

namespace scslam {
namespace {

using ::testing::HasSubstr;

RegistrationResult good() {
  RegistrationResult result;
  result.converged = true;
  result.inlier_ratio = result.overlap = 0.9;
  result.rmse_m = 0.05;
  return result;
}

TEST(LoopGates, PassAGoodResultAndNameWhatIsWrongWithABadOne) {
  LoopGateParams params;
  params.min_overlap = 0.5;
  params.min_inlier_ratio = 0.4;
  params.max_rmse_m = 0.25;
  params.max_degenerate_axes = 2;
  EXPECT_EQ(refusal(good(), params), "");
  RegistrationResult r = good();
  r.converged = false;
  EXPECT_THAT(refusal(r, params), HasSubstr("converge"));
  r = good(), r.overlap = 0.31;
  EXPECT_THAT(refusal(r, params), HasSubstr("overlap 0.31 < 0.50"));
  r = good(), r.inlier_ratio = 0.2;
  EXPECT_THAT(refusal(r, params), HasSubstr("inliers 0.20"));
  r = good(), r.rmse_m = 0.4;
  EXPECT_THAT(refusal(r, params), HasSubstr("rmse 0.400 m"));
  r = good(), r.degenerate_axes = 3;
  EXPECT_THAT(refusal(r, params), HasSubstr("3 directions"));
}

TEST(LoopGates, OdometryDisagreementIsCountedInSigmas) {
  LoopGateParams params;
  params.odometry_sigma_per_m = 0.01;
  const Pose predicted = Pose::Identity(), measured = poseFromYaw(0, {3.0, 0, 0});
  // 100 m at 1 % are 1 m of sigma: 3 m off are 3 sigma.
  EXPECT_NEAR(odometryDisagreement(measured, predicted, Matrix6d::Zero(), 100, false, params), 9.0, 0.01);
  EXPECT_NEAR(odometryDisagreement(measured, predicted, Matrix6d::Zero(), 100, true, params), 9.0, 0.01);
  // The path's own covariance widens the gate.
  EXPECT_NEAR(odometryDisagreement(measured, predicted, 8 * Matrix6d::Identity(), 100, false, params), 1.0, 0.01);
  // Planar data says nothing about height.
  const Pose higher = poseFromYaw(0, {0, 0, 50});
  EXPECT_NEAR(odometryDisagreement(higher, predicted, Matrix6d::Zero(), 100, true, params), 0.0, 1e-9);
}

}  // namespace
}  // namespace scslam
