// What every registration method promises (registration/registration.h), checked on each that is registered.
#include <Eigen/Eigenvalues>
#include <limits>

#include "scslam/registration/registration.h"
#include "support/support.h"

namespace scslam {
namespace {

using test::IsNear;

class RegistrationConformance : public ::testing::TestWithParam<std::string> {
 protected:
  static std::unique_ptr<Registration> make(int threads = 1) {
    return Registry<Registration>::instance().create(GetParam(), test::context(threads));
  }
};

Pose truth() { return poseFromYaw(2.4, {1.5, -0.8, 0.05}); }
Cloud sourceOf(std::uint32_t seed) { return transformed(test::aRoom(9000, seed), truth().inverse()); }

TEST_P(RegistrationConformance, ClosesALoopFromAGuessAsWrongAsAPlaceRecognisers) {
  const auto method = make();
  method->setTarget(test::aRoom(40000));
  const Pose guess = truth() * poseFromYaw(0.1, {-0.8, 0.7, 0.3});
  const RegistrationResult result = method->align(sourceOf(2), guess, false);
  EXPECT_TRUE(result.converged);
  EXPECT_THAT(result.T_target_source, IsNear(truth(), 0.01, 0.1));
  EXPECT_GT(result.inlier_ratio, 0.7);
  EXPECT_LE(result.inlier_ratio, 1.0);
  EXPECT_GT(result.overlap, 0.9);
  EXPECT_LE(result.overlap, 1.0);
  EXPECT_LT(result.rmse_m, 0.1);
  EXPECT_EQ(result.degenerate_axes, 0);
}

TEST_P(RegistrationConformance, TheBestOfSeveralGuessesWins) {
  const auto method = make();
  method->setTarget(test::aRoom(40000));
  const std::vector<Pose> guesses = {truth() * poseFromYaw(1.5, {1, 0, 0}),
                                     truth() * poseFromYaw(0.1, {-0.8, 0.7, 0.2})};
  const RegistrationResult result = method->align(sourceOf(2), guesses, false);
  EXPECT_TRUE(result.converged);
  EXPECT_THAT(result.T_target_source, IsNear(truth(), 0.01, 0.1));
}

TEST_P(RegistrationConformance, AHeadingWrongByHalfATurnIsFound) {
  const auto method = make();
  method->setTarget(test::aRoom(40000));
  const RegistrationResult result = method->align(sourceOf(2), truth() * poseFromYaw(M_PI + 0.05, {0.5, 0, 0}), false);
  EXPECT_THAT(result.T_target_source, IsNear(truth(), 0.01, 0.1));
}

TEST_P(RegistrationConformance, HessianIsSymmetricPositiveDefiniteAndHonest) {
  const auto method = make();
  method->setTarget(test::aRoom(40000));
  double sum = 0;
  constexpr int kRuns = 8;
  for (std::uint32_t seed = 2; seed < 2 + kRuns; ++seed) {
    const RegistrationResult result = method->align(sourceOf(seed), truth(), false);
    EXPECT_EQ(result.hessian, result.hessian.transpose());
    EXPECT_GT(result.hessian.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0);
    const Vector6d d = local(result.T_target_source, truth());
    sum += d.dot(result.hessian * d) / 6;
  }
  EXPECT_LT(sum / kRuns, 3.0) << "claims more than it knows";
}

TEST_P(RegistrationConformance, PlanarEstimatesXYAndYawOnly) {
  Cloud room;
  for (int i = -200; i < 200; ++i) {
    const float t = 0.025f * static_cast<float>(i);
    room.push(t, -3, 0), room.push(t, 4, 0), room.push(-5, 0.7f * t, 0), room.push(5, 0.7f * t, 0);
    if (i > 0) room.push(t, 1 + 0.3f * t, 0);
  }
  const Pose T = poseFromYaw(-0.7, {0.4, 0.6, 0});
  const auto method = make();
  method->setTarget(room);
  const RegistrationResult result =
      method->align(transformed(room, T.inverse()), T * poseFromYaw(0.06, {0.3, -0.2, 0}), true);
  EXPECT_TRUE(result.converged);
  EXPECT_THAT(result.T_target_source, IsNear(T, 0.01, 0.2));
  EXPECT_EQ(result.T_target_source.translation().z(), 0.0);
  EXPECT_EQ(result.T_target_source.linear()(2, 2), 1.0);
}

TEST_P(RegistrationConformance, AnotherPlaceLooksWorse) {
  const auto method = make();
  method->setTarget(test::aRoom(40000));
  Cloud elsewhere;  // a slope and a slanted wall
  for (int i = -60; i < 60; ++i)
    for (int j = 0; j < 30; ++j) {
      const float u = 0.2f * static_cast<float>(i), v = 0.2f * static_cast<float>(j);
      elsewhere.push(u, v, 0.6f * u + 0.2f * v);
      elsewhere.push(0.7f * u, 2 + 0.5f * u, v);
    }
  const RegistrationResult result = method->align(elsewhere, Pose::Identity(), false);
  const RegistrationResult right = method->align(sourceOf(2), truth(), false);
  EXPECT_LT(result.inlier_ratio, 0.6 * right.inlier_ratio);
}

TEST_P(RegistrationConformance, NeverThrowsForEmptyOrHostileClouds) {
  Cloud one, nans;
  one.push(1, 2, 3);
  for (int i = 0; i < 200; ++i) nans.push(std::numeric_limits<float>::quiet_NaN(), 1, 1);
  const auto method = make();
  EXPECT_FALSE(method->align(test::aRoom(1000), Pose::Identity(), false).converged) << "no target yet";
  for (const bool planar : {false, true}) {
    for (const Cloud& bad : {Cloud{}, one, nans}) {
      method->setTarget(bad);
      EXPECT_FALSE(method->align(test::aRoom(1000), Pose::Identity(), planar).converged);
      method->setTarget(test::aRoom(5000));
      const RegistrationResult result = method->align(bad, Pose::Identity(), planar);
      EXPECT_FALSE(result.converged);
      EXPECT_TRUE(result.hessian.allFinite());
    }
  }
}

TEST_P(RegistrationConformance, GivesTheSameBitsAgainAndForAnyNumberOfThreads) {
  const auto one = make(1), four = make(4);
  one->setTarget(test::aRoom(20000));
  four->setTarget(test::aRoom(20000));
  const Pose guess = truth() * poseFromYaw(0.08, {0.5, 0.5, 0});
  const RegistrationResult a = one->align(sourceOf(3), guess, false), b = four->align(sourceOf(3), guess, false);
  EXPECT_EQ(a.T_target_source.matrix(), b.T_target_source.matrix());
  EXPECT_EQ(a.hessian, b.hessian);
  EXPECT_EQ(one->align(sourceOf(3), guess, false).T_target_source.matrix(), a.T_target_source.matrix());
}

INSTANTIATE_TEST_SUITE_P(Methods, RegistrationConformance,
                         ::testing::ValuesIn(Registry<Registration>::instance().names()),
                         [](const auto& tested) { return tested.param; });

TEST(RegistrationRegistry, HoldsTheMethodsThatAreShipped) {
  EXPECT_EQ(Registry<Registration>::instance().names(), (std::vector<std::string>{"voxel_planes"}));
}

}  // namespace
}  // namespace scslam
