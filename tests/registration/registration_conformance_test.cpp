// What every registered registration method must do.
#include <Eigen/Eigenvalues>
#include <cmath>

#include "scslam/registration/loop_gates.h"
#include "scslam/registration/registration.h"
#include "support/support.h"

namespace scslam {
namespace {

using test::IsNear;

class RegistrationMethod : public testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<Registration> method(int threads = 1) {
    return Registry<Registration>::instance().create(GetParam(), test::context(threads));
  }
};

/// The room as a sensor at T_room_sensor would have it.
Cloud roomFrom(const Pose& T_room_sensor, std::uint32_t seed, std::size_t points = 12000) {
  return transformed(test::aRoom(points, seed), T_room_sensor.inverse());
}

TEST_P(RegistrationMethod, RecoversAKnownMotionFromTheDescriptorsYaw) {
  const auto registration = method();
  registration->setTarget(roomFrom(Pose::Identity(), 1, 30000));
  for (const double yaw : {0.0, 1.0, M_PI, -2.0}) {
    const Pose truth = poseFromYaw(yaw, {1.2, -0.8, 0.1});
    const RegistrationResult r = registration->align(roomFrom(truth, 2), poseFromYaw(yaw + 0.08, {0, 0, 0}), false);
    EXPECT_TRUE(r.converged) << yaw;
    EXPECT_THAT(r.T_target_source, IsNear(truth, 0.02, 0.2)) << yaw;
    EXPECT_EQ(refusal(r, LoopGateParams{}), "") << yaw;
  }
}

TEST_P(RegistrationMethod, HessianIsSymmetricPositiveAndNotAbsurd) {
  const auto registration = method();
  registration->setTarget(roomFrom(Pose::Identity(), 1, 30000));
  const RegistrationResult r =
      registration->align(roomFrom(poseFromYaw(0.1, {0.3, 0.2, 0}), 2), Pose::Identity(), false);
  EXPECT_LT((r.hessian - r.hessian.transpose()).norm(), 1e-9 * r.hessian.norm());
  const Vector6d eigenvalues = r.hessian.selfadjointView<Eigen::Lower>().eigenvalues();
  EXPECT_GT(eigenvalues.minCoeff(), 0);
  const double sigma_m = 1 / std::sqrt(r.hessian(0, 0));
  EXPECT_GT(sigma_m, 1e-4);
  EXPECT_LT(sigma_m, 0.1);
}

TEST_P(RegistrationMethod, PlanarDataMovesInThePlaneOnly) {
  Cloud target, source;
  for (int i = 0; i < 4000; ++i) {  // the outline of an L-shaped room
    const auto s = static_cast<float>(i % 400) / 40;
    const int wall = i / 400 % 5;
    const float x = wall == 0 ? s : wall == 1 ? 10.0f : wall == 2 ? 0.0f : wall == 3 ? s / 2 : 5.0f;
    const float y = wall == 0 ? 0.0f : wall == 1 ? s / 2 : wall == 2 ? s * 0.8f : wall == 3 ? 8.0f : 5.0f + s * 0.3f;
    target.push(x, y, 0);
  }
  const Pose truth = poseFromYaw(0.1, {0.4, -0.3, 0});
  source = transformed(target, truth.inverse());
  const auto registration = method();
  registration->setTarget(target);
  const RegistrationResult r = registration->align(source, Pose::Identity(), true);
  EXPECT_THAT(r.T_target_source, IsNear(truth, 0.03, 0.4));
  EXPECT_EQ(r.T_target_source.translation().z(), 0);
  EXPECT_EQ(r.T_target_source.linear()(2, 2), 1);
}

TEST_P(RegistrationMethod, EmptyTinyAndForeignCloudsDoNotConvergeNorThrow) {
  const auto registration = method();
  Cloud one;
  one.push(1, 2, 3);
  for (const Cloud& target : {Cloud(), one})
    for (const Cloud& source : {Cloud(), one, roomFrom(Pose::Identity(), 1, 500)}) {
      registration->setTarget(target);
      EXPECT_FALSE(registration->align(source, Pose::Identity(), false).converged);
      EXPECT_FALSE(registration->align(source, Pose::Identity(), true).converged);
    }
  registration->setTarget(roomFrom(Pose::Identity(), 1, 500));
  EXPECT_FALSE(registration->align(Cloud(), Pose::Identity(), false).converged);
}

TEST_P(RegistrationMethod, SameBitsForAnyNumberOfThreads) {
  const auto one = method(1), two = method(2);
  const Cloud target = roomFrom(Pose::Identity(), 1, 30000), source = roomFrom(poseFromYaw(0.2, {0.5, 0.1, 0}), 2);
  one->setTarget(target), two->setTarget(target);
  const RegistrationResult a = one->align(source, Pose::Identity(), false),
                           b = two->align(source, Pose::Identity(), false);
  EXPECT_EQ(a.T_target_source.matrix(), b.T_target_source.matrix());
  EXPECT_EQ(a.hessian, b.hessian);
}

INSTANTIATE_TEST_SUITE_P(All, RegistrationMethod, testing::ValuesIn(Registry<Registration>::instance().names()));

TEST(LoopGates, EachGateNamesItsFigure) {
  RegistrationResult good;
  good.converged = true, good.inlier_ratio = 0.97, good.overlap = 0.95, good.rmse_m = 0.05;
  const LoopGateParams params;
  EXPECT_EQ(refusal(good, params), "");
  const auto changed = [&](auto change) {
    RegistrationResult r = good;
    change(r);
    return refusal(r, params);
  };
  EXPECT_THAT(changed([](auto& r) { r.converged = false; }), testing::HasSubstr("converge"));
  EXPECT_THAT(changed([](auto& r) { r.overlap = 0.4; }), testing::HasSubstr("overlap 0.40"));
  EXPECT_THAT(changed([](auto& r) { r.inlier_ratio = 0.8; }), testing::HasSubstr("inliers 0.80"));
  EXPECT_THAT(changed([](auto& r) { r.rmse_m = 0.3; }), testing::HasSubstr("rmse 0.300"));
  EXPECT_THAT(changed([](auto& r) { r.degenerate_axes = 4; }), testing::HasSubstr("4 directions"));
}

TEST(LoopGates, OdometryMayDisagreeInProportionToTheWay) {
  const LoopGateParams params;
  const Pose measured = poseFromYaw(0, {4, 0, 0});
  EXPECT_GT(odometryDisagreement(measured, Pose::Identity(), Matrix6d::Zero(), 10, false, params),
            params.max_odometry_mahalanobis2);
  EXPECT_LT(odometryDisagreement(measured, Pose::Identity(), Matrix6d::Zero(), 100, false, params),
            params.max_odometry_mahalanobis2);
  const Pose off_in_z = poseFromYaw(0, {0, 0, 50});
  EXPECT_NEAR(odometryDisagreement(off_in_z, Pose::Identity(), Matrix6d::Zero(), 10, true, params), 0, 1e-12)
      << "planar: z says nothing";
  EXPECT_EQ(implausible(poseFromYaw(0, {9, 0, 0}), 20, params), "");
  EXPECT_THAT(implausible(poseFromYaw(0, {60, 0, 0}), 20, params), testing::HasSubstr("60.0 m away"));
}

}  // namespace
}  // namespace scslam
