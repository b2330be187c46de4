#include "scslam/odometry/imu_stream.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scslam/odometry/imu_check.h"
#include "scslam/odometry/imu_deskew.h"
#include "support/support.h"

namespace scslam {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

Stamp at(double t) { return stampFromNanoseconds(1'600'000'000'000'000'000 + std::llround(t * 1e9)); }

/// Rates and forces that grow with time, from `begin` to `end` at 100 Hz.
std::vector<ImuSample> ramp(double begin, double end) {
  std::vector<ImuSample> samples;
  for (double t = begin; t <= end + 1e-9; t += 0.01) samples.push_back({at(t), {t, 0, 0}, {0, 0, 9.8 + t}});
  return samples;
}

TEST(ImuStream, ReadingsBetweenTwoStampsBeginAndEndThere) {
  ImuStream stream(0.05);
  stream.add(ramp(0, 1));
  const auto readings = stream.between(at(0.204), at(0.236));
  ASSERT_EQ(readings.size(), 5U) << "0.204, 0.21, 0.22, 0.23, 0.236";
  EXPECT_NEAR(readings.front().t, 0, 1e-9);
  EXPECT_NEAR(readings.back().t, 0.032, 1e-9);
  for (const ImuReading& r : readings) EXPECT_NEAR(r.gyro.x(), 0.204 + r.t, 1e-6);
}

TEST(ImuStream, EndsAreHeldForAGapAndNoLonger) {
  ImuStream stream(0.05);
  stream.add(ramp(0, 1));
  const auto late = stream.between(at(0.98), at(1.04)), early = stream.between(at(-0.03), at(0.02));
  ASSERT_FALSE(late.empty());
  EXPECT_NEAR(late.back().gyro.x(), 1, 1e-9);
  ASSERT_FALSE(early.empty());
  EXPECT_NEAR(early.front().gyro.x(), 0, 1e-9);
  EXPECT_TRUE(stream.between(at(0.98), at(1.06)).empty());
  EXPECT_TRUE(stream.between(at(-0.06), at(0.02)).empty());
  EXPECT_TRUE(stream.between(at(0.5), at(0.5)).empty());
  EXPECT_TRUE(stream.between(at(0.5), at(0.4)).empty());
}

TEST(ImuStream, AGapInsideIsBridgedOnlyWhenShort) {
  ImuStream stream(0.05);
  stream.add(ramp(0, 0.5));
  stream.add(ramp(0.54, 0.8));
  stream.add(ramp(0.9, 1));
  EXPECT_FALSE(stream.between(at(0.45), at(0.6)).empty());
  EXPECT_TRUE(stream.between(at(0.75), at(0.95)).empty());
}

TEST(ImuStream, ClockAndUnitsAreCorrected) {
  ImuStream stream(0.05);
  stream.add(ramp(0, 1));
  stream.time_offset_s = 0.02, stream.accel_scale = 2;
  const auto readings = stream.between(at(0.5), at(0.6));
  EXPECT_NEAR(readings.front().gyro.x(), 0.48, 1e-6) << "what was stamped 0.48 happened at 0.5";
  EXPECT_NEAR(readings.front().accel.z(), 2 * (9.8 + 0.48), 1e-6);
}

TEST(ImuStream, ForgettingKeepsWhatIsNeeded) {
  ImuStream stream(0.05);
  stream.add(ramp(0, 1));
  const auto before = stream.between(at(0.504), at(0.6));
  stream.forgetBefore(at(0.504));
  EXPECT_LT(stream.samples().size(), 55U);
  const auto after = stream.between(at(0.504), at(0.6));
  ASSERT_EQ(before.size(), after.size());
  EXPECT_EQ(before.front().gyro, after.front().gyro);
}

std::deque<ImuSample> resting(const Vector3d& force) {
  std::deque<ImuSample> samples;
  for (int i = 0; i < 20; ++i) samples.push_back({at(0.01 * i), Vector3d(0.001, 0, 0), force});
  return samples;
}

TEST(ImuStart, SaysWhatIsWrongWithAnImu) {
  const auto start = [](const Vector3d& force, const Pose& T_base_imu = Pose::Identity()) {
    return startOf(resting(force), T_base_imu, 9.81, 60);
  };
  const ImuStart good = start({0.1, 0.2, 9.8});
  EXPECT_TRUE(good.usable && good.still);
  EXPECT_TRUE(good.note.empty());
  const ImuStart in_g = start({0, 0.01, 1.0});
  EXPECT_TRUE(in_g.usable && in_g.still);
  EXPECT_NEAR(in_g.accel.z(), 9.81, 1e-9);
  EXPECT_THAT(in_g.note, HasSubstr("are in g"));
  const ImuStart swapped = start({0, 9.8, 0});
  EXPECT_FALSE(swapped.usable);
  EXPECT_THAT(swapped.note, HasSubstr("up is (0.00, 1.00, 0.00) of the base frame, 90 degrees from its z axis"));
  Pose T_base_imu = Pose::Identity();
  T_base_imu.linear() = Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitX()).toRotationMatrix();
  EXPECT_TRUE(start({0, 9.8, 0}, T_base_imu).note.empty()) << "mounted so, and the recording says so";
  const ImuStart none = start({0.01, 0, 0.02});
  EXPECT_FALSE(none.usable);
  EXPECT_THAT(none.note, HasSubstr("neither gravity"));
  EXPECT_FALSE(startOf({}, Pose::Identity(), 9.81, 60).enough);
}

/// Turns of a robot that swings, seen by scans every 0.1 s and by a gyroscope with a clock behind by `tau`, times
/// `scale`.
ImuCheck swing(double tau, double scale) {
  ImuCheck check;
  const auto angle = [](double t) { return 0.5 * std::sin(2 * t) + 0.1 * std::sin(5 * t); };
  const auto rate = [](double t) { return std::cos(2 * t) + 0.5 * std::cos(5 * t); };
  for (int k = 0; k < 100; ++k) {
    const double a = 0.1 * k, b = a + 0.1, noise = 1e-4 * std::sin(37.0 * k);
    check.add(scale * Vector3d(0, 0, angle(b + tau) - angle(a + tau)), {noise, 0, angle(b) - angle(a) + noise},
              scale * Vector3d(0, 0, rate(a + tau)), scale * Vector3d(0, 0, rate(b + tau)));
  }
  return check;
}

TEST(ImuCheck, FindsTheOffsetOfTheClock) {
  for (const double tau : {0.05, -0.03, 0.0}) {
    const ImuCheck::Offset offset = swing(tau, 1).offset();
    EXPECT_NEAR(offset.seconds, tau, 2e-3);
    EXPECT_LT(offset.sigma_s, 2e-3);
    EXPECT_EQ(swing(tau, 1).disagreement(), "");
  }
  EXPECT_GT(ImuCheck().offset().sigma_s, 0.5) << "nothing seen, nothing known";
}

TEST(ImuCheck, SaysWhenTurnsDisagree) {
  EXPECT_THAT(swing(0, 180 / M_PI).disagreement(), HasSubstr("degrees per second"));
  EXPECT_THAT(swing(0, -1).disagreement(), HasSubstr("turns against the scans"));
  EXPECT_THAT(swing(0, 3).disagreement(), HasSubstr("not those of the scans"));
  EXPECT_EQ(ImuCheck().disagreement(), "");
}

TEST(ImuDeskew, PutsEveryPointWhereItWasAtTheStamp) {
  // Turning at 2 rad/s, 3 m/s forward and braking with 4 m/s^2, the IMU off the axis.
  const Vector3d gravity(0, 0, -9.81);
  const Pose T_base_imu = poseFromYaw(0.5, {0.4, 0.1, 0.2});
  const auto T_odom_base = [](double t) { return poseFromYaw(2 * t, {3 * t - 2 * t * t, 0, 0}); };
  std::vector<ImuReading> readings;
  for (int i = 0; i <= 20; ++i) {
    const double t = 0.005 * i;
    const Pose T = T_odom_base(t);
    const Vector3d lever = T.linear() * T_base_imu.translation(), w(0, 0, 2);
    const Vector3d a = Vector3d(-4, 0, 0) + w.cross(w.cross(lever));
    readings.push_back({t, w, (T.linear() * T_base_imu.linear()).transpose() * (a - gravity)});
  }
  const Pose T_odom_imu = T_odom_base(0) * T_base_imu;
  const Vector3d v = Vector3d(3, 0, 0) + Vector3d(0, 0, 2).cross(Vector3d(T_base_imu.translation()));
  const SweepMotion motion =
      sweepMotion(readings, {T_odom_imu.linear(), T_odom_imu.translation(), v}, {}, gravity, T_base_imu);
  Cloud cloud;
  std::vector<Vector3d> truth;
  for (int i = 0; i <= 30; ++i) {
    const double t = i / 300.0;
    truth.push_back({10.0 * std::cos(i), 10.0 * std::sin(i), 1});
    const Eigen::Vector3f p = (T_odom_base(t).inverse() * truth.back()).cast<float>();
    cloud.push(p.x(), p.y(), p.z());
    cloud.dt.push_back(static_cast<float>(t));
  }
  deskew(cloud, motion);
  for (std::size_t i = 0; i < truth.size(); ++i)
    EXPECT_LT((cloud.point(i).cast<double>() - truth[i]).norm(), 5e-4) << i;
}

}  // namespace
}  // namespace scslam
