// LiDAR and IMU together, by a filter (`lio`) and by a smoother (`lio_smoother`).
#include <gtest/gtest.h>

#include <random>

#include "odometry/lio_drive.h"

namespace scslam {
namespace {

using test::InertialDrive;
using test::IsNear;
using ::testing::HasSubstr;

std::unique_ptr<Odometry> frontEnd(const std::string& name, const std::vector<std::string>& settings = {}) {
  const auto& entry = Registry<Odometry>::instance().find(name);
  const auto params = entry.defaults();
  for (const auto& setting : settings) setParam(*params, setting);
  return entry.create(*params, test::context());
}

struct Driven {
  double worst_m = 0, worst_deg = 0;  ///< against the truth, placed at the first scan
  double last_m = 0;
  std::string notes;
  int lost = 0;
};

using Change = std::function<void(std::size_t, Scan&)>;

Driven drive(Odometry& odometry, const InertialDrive& way, std::size_t first, std::size_t end,
             const Change& change = {}) {
  Driven result;
  Pose T_odom_world;
  for (std::size_t k = first; k < end; ++k) {
    Scan scan = way.scan(k);
    if (change) change(k, scan);
    const OdometryStep step = odometry.step(scan);
    if (k == first) T_odom_world = step.T_odom_base * way.pose(way.start(k)).inverse();
    const Vector6d error = local(T_odom_world * way.pose(way.start(k)), step.T_odom_base);
    result.last_m = error.head<3>().norm();
    result.worst_m = std::max(result.worst_m, result.last_m);
    result.worst_deg = std::max(result.worst_deg, error.tail<3>().norm() * 180 / M_PI);
    result.lost += !step.quality.ok;
    if (!step.quality.note.empty()) result.notes += step.quality.note + "\n";
  }
  return result;
}

class Inertial : public ::testing::TestWithParam<std::string> {};

TEST_P(Inertial, FollowsAWildDrive) {
  const Driven driven = drive(*frontEnd(GetParam()), test::wildDrive(), 0, 80);
  EXPECT_LT(driven.worst_m, 0.03);
  EXPECT_LT(driven.worst_deg, 0.3);
  EXPECT_EQ(driven.lost, 0);
  EXPECT_EQ(driven.notes, "");
}

TEST_P(Inertial, MayBeginInMotion) {
  const Driven driven = drive(*frontEnd(GetParam()), test::wildDrive(), 25, 80);
  EXPECT_LT(driven.worst_m, 0.065) << "0.082 when the first sweep is not compensated";
  EXPECT_EQ(driven.lost, 0);
}

TEST_P(Inertial, PutsThePointsWhereTheyWereAtTheStamp) {
  const InertialDrive way = test::wildDrive();
  const auto odometry = frontEnd(GetParam(), {"map.min_range_m=0.001"});
  for (std::size_t k = 0; k < 30; ++k) odometry->step(way.scan(k));
  const Scan scan = way.scan(30);
  const OdometryStep step = odometry->step(scan);
  const Cloud truth = test::shuffled(test::aRoom(6007, 40, 0.01));
  ASSERT_EQ(step.cloud.size(), truth.size());
  double mean = 0, uncompensated = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Eigen::Vector3d p_base = way.pose(way.start(30)).inverse() * truth.point(i).cast<double>();
    mean += (step.cloud.point(i).cast<double>() - p_base).norm() / static_cast<double>(truth.size());
    uncompensated +=
        (scan.T_base_sensor * scan.cloud.point(i).cast<double>() - p_base).norm() / static_cast<double>(truth.size());
  }
  EXPECT_LT(mean, 0.01);
  EXPECT_GT(uncompensated, 0.1) << "the test must tell";
}

TEST_P(Inertial, TheFirstPoseIsLevel) {
  InertialDrive way = test::wildDrive();
  std::vector<Pose> control(8, Pose::Identity());
  for (Pose& T : control) T.linear() = poseFromYaw(0.5, {0, 0, 0}).linear() * so3Exp({0.2, -0.15, 0});
  way.trajectory = sim::Trajectory(control, 0.5);
  const Pose T = frontEnd(GetParam())->step(way.scan(0)).T_odom_base;
  EXPECT_NEAR(yawOf(T), 0, 1e-9);
  const Eigen::Vector3d up_base = way.pose(0).linear().transpose() * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR((T.linear() * up_base).z(), 1, 1e-4) << "but for the bias of the accelerometer";
}

/// Two walls, floor and ceiling, 100 m of them and no end in sight: LiDAR does not see motion along it.
InertialDrive corridor() {
  std::vector<Pose> control;
  for (int i = -1; i < 110; ++i) {
    const double t = std::max(0.0, 0.1 * i - 0.5);
    const double x = t < 4 ? 0.5 * t * t : 8 + 4 * (t - 4);  // 1 m/s^2 up to 4 m/s
    control.push_back(poseFromYaw(0.02 * std::sin(0.7 * t), {x, 0.1 * std::sin(0.5 * t), 0}));
  }
  InertialDrive way = {{control, 0.1}, test::tiltedImu(), {}};
  way.world = [](std::uint32_t seed) {
    std::mt19937 random(seed);
    const auto uniform = [&random] { return static_cast<float>(random()) / 4294967296.0f; };
    Cloud cloud;
    for (int i = 0; i < 8000; ++i) {
      const float x = 160 * uniform() - 60, noise = 0.01f * (uniform() + uniform() - 1);
      if (i % 4 == 0) cloud.push(x, 3 * (uniform() - 0.5f), noise);
      if (i % 4 == 1) cloud.push(x, 3 * (uniform() - 0.5f), 3 + noise);
      if (i % 4 == 2) cloud.push(x, 1.5f + noise, 3 * uniform());
      if (i % 4 == 3) cloud.push(x, -1.5f + noise, 3 * uniform());
    }
    return cloud;
  };
  return way;
}

TEST_P(Inertial, TheImuCarriesThroughACorridor) {
  const auto keepNear = [](std::size_t, Scan& scan) {  // what a LiDAR of 20 m sees: no end
    std::vector<std::uint8_t> keep(scan.cloud.size());
    for (std::size_t i = 0; i < keep.size(); ++i) keep[i] = scan.cloud.point(i).norm() < 20;
    scan.cloud.filter(keep);
  };
  const Driven with = drive(*frontEnd(GetParam()), corridor(), 0, 90, keepNear);
  EXPECT_LT(with.worst_m, 0.005 * 26 + 0.05) << "0.5 % of the way";
  const Driven without = drive(*frontEnd(GetParam()), corridor(), 0, 90, [&](std::size_t k, Scan& scan) {
    keepNear(k, scan);
    scan.imu.clear();
  });
  EXPECT_GT(without.worst_m, 1) << "the test must tell";
}

TEST_P(Inertial, WithoutAnImuItSaysSoAndGoesOn) {
  const InertialDrive way = test::wildDrive();
  const Driven driven = drive(*frontEnd(GetParam()), way, 0, 40, [](std::size_t, Scan& scan) { scan.imu.clear(); });
  EXPECT_THAT(driven.notes, HasSubstr("no IMU readings come with the scans"));
  EXPECT_LT(driven.last_m, 0.3);
}

TEST_P(Inertial, SurvivesAGapInTheImu) {
  const Driven driven = drive(*frontEnd(GetParam()), test::wildDrive(), 0, 80, [](std::size_t k, Scan& scan) {
    if (k >= 30 && k < 36) scan.imu.clear();
  });
  EXPECT_THAT(driven.notes, HasSubstr("no IMU for this step"));
  EXPECT_LT(driven.last_m, 0.05);
  EXPECT_EQ(driven.lost, 0);
}

TEST_P(Inertial, IsFoundAgainAfterFiveSecondsOfBlindness) {
  const InertialDrive way = test::wildDrive();
  const auto odometry = frontEnd(GetParam());
  const Driven driven = drive(*odometry, way, 0, 110, [](std::size_t k, Scan& scan) {
    if (k >= 40 && k < 90) scan.cloud = {};
  });
  EXPECT_EQ(driven.lost, 50);
  EXPECT_LT(driven.last_m, 0.05);
}

TEST_P(Inertial, BlindnessLeavesAWeakFactorInsteadOfALie) {
  const InertialDrive way = test::wildDrive();
  const auto odometry = frontEnd(GetParam());
  drive(*odometry, way, 0, 30);
  const double seeing = odometry->step(way.scan(30)).covariance(0, 0);
  double blind = 0;
  for (std::size_t k = 31; k < 70; ++k) {
    Scan scan = way.scan(k);
    scan.cloud = {};
    blind = odometry->step(scan).covariance(0, 0);
  }
  EXPECT_GT(blind, 9 * seeing);
}

TEST_P(Inertial, TakesAnImuInGAndSaysSo) {
  const Driven driven = drive(*frontEnd(GetParam()), test::wildDrive(), 0, 60, [](std::size_t, Scan& scan) {
    for (ImuSample& sample : scan.imu) sample.accel_m_s2 /= 9.81;
  });
  EXPECT_THAT(driven.notes, HasSubstr("are in g"));
  EXPECT_LT(driven.worst_m, 0.03);
}

TEST_P(Inertial, SaysThatAxesAreSwappedAndGoesOnWithoutThem) {
  const Driven driven = drive(*frontEnd(GetParam()), test::wildDrive(), 0, 40, [](std::size_t, Scan& scan) {
    for (ImuSample& sample : scan.imu) {
      std::swap(sample.accel_m_s2.y(), sample.accel_m_s2.z());
      std::swap(sample.gyro_rad_s.y(), sample.gyro_rad_s.z());
    }
  });
  EXPECT_THAT(driven.notes, HasSubstr("swapped axes"));
  EXPECT_LT(driven.last_m, 0.3);
}

TEST_P(Inertial, FindsThatTheClocksDiffer) {
  for (const int late_ms : {50, -50}) {
    const Driven driven = drive(*frontEnd(GetParam()), test::wildDrive(), 0, 100, [late_ms](std::size_t, Scan& scan) {
      for (ImuSample& sample : scan.imu) sample.stamp += std::chrono::milliseconds(late_ms);
    });
    EXPECT_THAT(driven.notes, HasSubstr(late_ms > 0 ? "ms ahead of that of the scans" : "ms behind that of the scans"));
    EXPECT_LT(driven.last_m, 0.05) << late_ms;
  }
}

TEST_P(Inertial, SaysThatPointsHaveNoTime) {
  const Driven driven =
      drive(*frontEnd(GetParam()), test::wildDrive(), 0, 5, [](std::size_t, Scan& scan) { scan.cloud.dt.clear(); });
  EXPECT_THAT(driven.notes, HasSubstr("no time per point"));
}

TEST_P(Inertial, ContinuesFromItsStateWithTheSameBits) {
  const InertialDrive way = test::wildDrive();
  const auto whole = frontEnd(GetParam()), resumed = frontEnd(GetParam());
  for (std::size_t k = 0; k < 20; ++k) whole->step(way.scan(k));
  ByteWriter state;
  whole->save(state);
  ByteReader reader(state.bytes());
  resumed->load(reader);
  EXPECT_TRUE(reader.done());
  for (std::size_t k = 20; k < 26; ++k) {
    const OdometryStep a = whole->step(way.scan(k)), b = resumed->step(way.scan(k));
    EXPECT_EQ(a.T_odom_base.matrix(), b.T_odom_base.matrix()) << k;
    EXPECT_EQ(a.covariance, b.covariance) << k;
    EXPECT_EQ(a.cloud.x, b.cloud.x) << k;
  }
  ByteWriter end_a, end_b;
  whole->save(end_a), resumed->save(end_b);
  EXPECT_EQ(end_a.bytes(), end_b.bytes());
}

INSTANTIATE_TEST_SUITE_P(FrontEnds, Inertial, ::testing::Values("lio", "lio_smoother"),
                         [](const auto& tested) { return tested.param; });

}  // namespace
}  // namespace scslam
