#include "scslam/graph/factor_error.h"

#include "graph/graph_fixtures.h"
#include "support/support.h"

namespace scslam {
namespace {

Matrix6d numericJacobian(const Factor& factor, const Pose& X_i, const Pose& X_j, bool of_i) {
  constexpr double h = 1e-6;
  Matrix6d J;
  for (int k = 0; k < 6; ++k) {
    Vector6d step = Vector6d::Zero();
    step(k) = h;
    const auto at = [&](const Vector6d& d) {
      return of_i ? factorError(factor, retract(X_i, d), X_j) : factorError(factor, X_i, retract(X_j, d));
    };
    J.col(k) = (at(step) - at(-step)) / (2 * h);
  }
  return J;
}

TEST(FactorError, JacobiansAgreeWithNumericOnes) {
  std::mt19937 random(11);
  for (int trial = 0; trial < 200; ++trial) {
    const Pose X_i = test::randomPose(random), X_j = test::randomPose(random);
    Factor factor;
    factor.T_i_j = retract(X_i.inverse() * X_j, test::randomVector(random, 1, 0.8));
    for (const auto kind : {FactorKind::kLoop, FactorKind::kPrior}) {
      factor.kind = kind;
      if (kind == FactorKind::kPrior) factor.T_i_j = retract(X_j, test::randomVector(random, 1, 0.8));
      Matrix6d J_i, J_j;
      factorError(factor, X_i, X_j, J_i, J_j);
      EXPECT_LT((J_i - numericJacobian(factor, X_i, X_j, true)).norm(), 1e-7);
      EXPECT_LT((J_j - numericJacobian(factor, X_i, X_j, false)).norm(), 1e-7);
    }
  }
}

TEST(FactorError, JacobiansOfPositionsAndGravityAgreeWithNumericOnes) {
  std::mt19937 random(12);
  for (int trial = 0; trial < 200; ++trial) {
    const Pose X_i = test::randomPose(random), X_j = test::randomPose(random);
    Factor factor;
    factor.arm = test::randomVector(random, 2, 0).head<3>();
    factor.T_i_j = test::randomPose(random);
    for (const auto kind : {FactorKind::kPosition, FactorKind::kGravity}) {
      factor.kind = kind;
      if (kind == FactorKind::kGravity) factor.arm.normalize();
      Matrix6d J_i, J_j;
      const Vector6d r = factorError(factor, X_i, X_j, J_i, J_j);
      EXPECT_EQ(r, factorError(factor, X_i, X_j));
      EXPECT_LT((J_i - numericJacobian(factor, X_i, X_j, true)).norm(), 1e-7);
      EXPECT_LT((J_j - numericJacobian(factor, X_i, X_j, false)).norm(), 1e-7);
    }
  }
}

TEST(FactorError, AntennaAtItsMeasuredPlaceAndALevelPoseHaveNone) {
  Factor position, gravity;
  position.kind = FactorKind::kPosition;
  position.arm = {1, 0, 2};
  const Pose T_map_enu = poseFromYaw(0.7, {10, -5, 1}), X = poseFromYaw(-0.4, {3, 4, 5});
  position.T_i_j.translation() = T_map_enu.inverse() * (X * position.arm);
  EXPECT_LT(factorError(position, T_map_enu, X).norm(), 1e-12);
  gravity.kind = FactorKind::kGravity;
  gravity.arm = {0, 0, 1};
  EXPECT_LT(factorError(gravity, X, X).norm(), 1e-12);
  const Pose tilted = X * Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY());
  EXPECT_NEAR(factorError(gravity, tilted, tilted).norm(), std::sin(0.1), 1e-12);
}

TEST(FactorError, IsTranslationAndRotationVectorOfTheDifference) {
  Factor factor;
  factor.T_i_j = poseFromYaw(0.3, {1, 2, 3});
  const Pose X_i = poseFromYaw(-1, {4, 5, 6});
  Vector6d d;
  d << 0.1, -0.2, 0.3, 0.02, 0.4, -0.1;
  EXPECT_LT((factorError(factor, X_i, X_i * retract(factor.T_i_j, d)) - d).norm(), 1e-12);
}

TEST(FactorError, Chi2UsesTheWholeInformationMatrix) {
  std::mt19937 random(5);
  PoseGraph graph;
  graph.poses = {test::randomPose(random), test::randomPose(random)};
  const Vector6d d = test::randomVector(random, 1, 0.5);
  graph.factors.push_back(test::between(graph.poses, 0, 1, FactorKind::kLoop));
  graph.factors[0].information = test::randomInformation(random);
  graph.poses[1] = retract(graph.poses[1], d);
  EXPECT_NEAR(graphChi2(graph), d.dot(graph.factors[0].information * d), 1e-10);
}

}  // namespace
}  // namespace scslam
