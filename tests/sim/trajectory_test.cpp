#include "sim/trajectory.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scslam/core/counter_random.h"
#include "support/support.h"

namespace scslam::sim {
namespace {

using Eigen::Vector3d;
using test::IsNear;

/// Control poses that wander and tumble.
std::vector<Pose> tumbling(int n, std::uint64_t seed = 1) {
  RandomSequence random(CounterRandom(seed, RandomStream::kDrive));
  std::vector<Pose> poses = {Pose::Identity()};
  while (static_cast<int>(poses.size()) < n) {
    Vector6d step;
    for (int k = 0; k < 6; ++k) step[k] = random.uniform(-0.6, 0.6);
    poses.push_back(retract(poses.back(), step));
  }
  return poses;
}

/// Of f at t, to the fourth order.
template <class F>
auto derivative(const F& f, double t, double h) {
  return Vector3d((8 * (f(t + h) - f(t - h)) - (f(t + 2 * h) - f(t - 2 * h))) / (12 * h));
}

constexpr double kKnot = 0.4;

class Derivatives : public ::testing::Test {
 protected:
  Trajectory trajectory_{tumbling(20), kKnot};
  /// Instants within a knot interval, well away from its ends.
  template <class F>
  void atInstants(const F& check) const {
    for (int i = 0; i < 17; ++i)
      for (double u : {0.1, 0.37, 0.5, 0.88}) check((i + u) * kKnot);
  }
};

TEST_F(Derivatives, StateHasThePoseOfPose) {
  atInstants(
      [&](double t) { EXPECT_THAT(trajectory_.state(t).T_world_base, IsNear(trajectory_.pose(t), 1e-12, 1e-9)); });
}

TEST_F(Derivatives, VelocityAndAccelerationAreThoseOfThePosition) {
  const auto position = [&](double t) { return Vector3d(trajectory_.pose(t).translation()); };
  const auto velocity = [&](double t) { return trajectory_.state(t).velocity; };
  atInstants([&](double t) {
    EXPECT_LT((trajectory_.state(t).velocity - derivative(position, t, 1e-3)).norm(), 1e-8) << "at " << t;
    EXPECT_LT((trajectory_.state(t).acceleration - derivative(velocity, t, 1e-3)).norm(), 1e-8) << "at " << t;
  });
}

TEST_F(Derivatives, AngularRatesAreThoseOfTheRotationInTheBaseFrame) {
  const auto rate = [&](double t) { return trajectory_.state(t).angular_velocity; };
  atInstants([&](double t) {
    const Pose T = trajectory_.pose(t);
    const auto turned = [&](double s) { return so3Log(T.linear().transpose() * trajectory_.pose(s).linear()); };
    EXPECT_LT((rate(t) - derivative(turned, t, 1e-3)).norm(), 1e-8) << "at " << t;
    EXPECT_LT((trajectory_.state(t).angular_acceleration - derivative(rate, t, 1e-3)).norm(), 1e-7) << "at " << t;
  });
}

TEST_F(Derivatives, NothingJumpsAtTheKnots) {
  constexpr double kStep = 1e-9;
  for (int i = 1; i < 17; ++i) {
    const MotionState a = trajectory_.state(i * kKnot - kStep), b = trajectory_.state(i * kKnot + kStep);
    EXPECT_THAT(a.T_world_base, IsNear(b.T_world_base, 1e-7, 1e-5)) << "knot " << i;
    EXPECT_LT((a.velocity - b.velocity).norm(), 1e-6) << "knot " << i;
    EXPECT_LT((a.acceleration - b.acceleration).norm(), 1e-5) << "knot " << i;
    EXPECT_LT((a.angular_velocity - b.angular_velocity).norm(), 1e-6) << "knot " << i;
    EXPECT_LT((a.angular_acceleration - b.angular_acceleration).norm(), 1e-5) << "knot " << i;
  }
}

TEST_F(Derivatives, AccelerationDoesChangeAcrossAKnot) {
  // So that the test above compares something.
  EXPECT_GT((trajectory_.state(3.0 * kKnot).acceleration - trajectory_.state(3.5 * kKnot).acceleration).norm(), 0.05);
}

TEST(Trajectory, LastsOneKnotIntervalForEachControlPoseButThree) {
  EXPECT_DOUBLE_EQ(Trajectory(tumbling(4), 0.5).duration(), 0.5);
  EXPECT_DOUBLE_EQ(Trajectory(tumbling(103), 0.1).duration(), 10.0);
}

TEST(Trajectory, TimesOutsideAreClampedToTheEnds) {
  const Trajectory trajectory(tumbling(12), 0.3);
  const double end = trajectory.duration();
  EXPECT_EQ(trajectory.pose(-5).matrix(), trajectory.pose(0).matrix());
  EXPECT_EQ(trajectory.pose(end + 5).matrix(), trajectory.pose(end).matrix());
  EXPECT_EQ(trajectory.state(end + 5).velocity, trajectory.state(end).velocity);
  EXPECT_TRUE(isRigid(trajectory.pose(std::numeric_limits<double>::infinity())));
}

TEST(Trajectory, StraightAndEvenControlPosesGiveEvenMotion) {
  std::vector<Pose> poses;
  for (int i = 0; i < 12; ++i) poses.push_back(poseFromYaw(0.5, {2.0 * i, 1.0 * i, 0}));
  const Trajectory trajectory(poses, 0.5);
  for (double t = 0; t <= trajectory.duration(); t += 0.07) {
    const MotionState s = trajectory.state(t);
    EXPECT_LT((s.velocity - Vector3d(4, 2, 0)).norm(), 1e-12);
    EXPECT_LT(s.acceleration.norm() + s.angular_velocity.norm() + s.angular_acceleration.norm(), 1e-12);
    EXPECT_LT((s.T_world_base.translation() - Vector3d(2 + 4 * t, 1 + 2 * t, 0)).norm(), 1e-12);
  }
  EXPECT_NEAR(trajectory.length(), 9 * std::sqrt(5.0), 1e-9);
}

TEST(Trajectory, EvenTurnsGiveAConstantRate) {
  std::vector<Pose> poses;
  for (int i = 0; i < 40; ++i) poses.push_back(poseFromYaw(0.3 * i, Vector3d::Zero()));  // several full turns
  const Trajectory trajectory(poses, 0.1);
  for (double t = 0; t <= trajectory.duration(); t += 0.033) {
    EXPECT_LT((trajectory.state(t).angular_velocity - Vector3d(0, 0, 3)).norm(), 1e-9);
    EXPECT_LT(trajectory.state(t).angular_acceleration.norm(), 1e-9);
  }
}

TEST(Trajectory, TooFewControlPosesOrNoTimeIsAUsageError) {
  EXPECT_THROW(Trajectory(tumbling(3), 1), Error);
  EXPECT_THROW(Trajectory(tumbling(5), 0), Error);
  EXPECT_THROW(Trajectory(tumbling(5), std::nan("")), Error);
}

}  // namespace
}  // namespace scslam::sim
