// radar_surface on sweeps whose truth is known: motion and Doppler within a sweep, rotated images, what groups say.
#include <cmath>

#include "odometry/radar_drive.h"
#include "scslam/core/deskew.h"
#include "scslam/odometry/frontends/radar_surface/oriented_points.h"
#include "scslam/odometry/odometry.h"
#include "scslam/odometry/radar_odometry.h"

namespace scslam {
namespace {

using radar_surface::OrientedPoints;
using radar_surface::orientedPoints;
using test::IsNear;

std::unique_ptr<Odometry> radarSurface(const std::vector<std::string>& sets = {}) {
  const auto& entry = Registry<Odometry>::instance().find("radar_surface");
  auto params = entry.defaults();
  for (const auto& set : sets) setParam(*params, set);
  return entry.create(*params, test::context());
}

/// 2 m/s and 30 deg/s, from the first sweep on: half a metre and 7.5 degrees a sweep.
const Vector6d kTwist = (Vector6d() << 2, 0, 0, 0, 0, 0.52).finished();

test::Drive fastArc(std::size_t steps, double doppler_beta_s) {
  test::RadarSensor sensor;
  sensor.sweep_s = 0.25, sensor.doppler_beta_s = doppler_beta_s;
  test::Drive drive;
  Pose T = poseFromYaw(0.2, {0, -3.5, 0});
  for (std::size_t k = 0; k < steps; ++k) {
    drive.T_world_base.push_back(T);
    drive.scans.push_back(test::radarAt(k, T, test::roomWorld(), sensor, kTwist));
    T = retract(T, sensor.sweep_s * kTwist);
  }
  return drive;
}

double toNearestWall(const Eigen::Vector3d& p) {
  double nearest = std::min(10 - std::abs(p.x()), 6 - std::abs(p.y()));
  nearest = std::abs(nearest);
  const test::BoxWorld room = test::roomWorld();
  for (std::size_t k = 1; k < room.boxes.size(); ++k) {
    const auto& [low, high] = room.boxes[k];
    const Eigen::Vector2d q = p.head<2>(), inside = q.cwiseMax(low.head<2>()).cwiseMin(high.head<2>());
    const double within = std::min((q - low.head<2>()).minCoeff(), (high.head<2>() - q).minCoeff());
    nearest = std::min(nearest, within > 0 ? within : (q - inside).norm());
  }
  return nearest;
}

struct Outcome {
  double worst_m = 0, worst_deg = 0;  ///< against the truth, from the first sweep on
  double off_wall_m = 0;              ///< mean distance of the last cloud from the walls, placed by the truth
};

Outcome driven(Odometry& odometry, const test::Drive& drive) {
  Outcome outcome;
  for (std::size_t k = 0; k < drive.scans.size(); ++k) {
    const OdometryStep step = odometry.step(drive.scans[k]);
    EXPECT_TRUE(step.quality.ok) << k << ": " << step.quality.note;
    const Vector6d d = local(drive.T_world_base[0].inverse() * drive.T_world_base[k], step.T_odom_base);
    outcome.worst_m = std::max(outcome.worst_m, d.head<3>().norm());
    outcome.worst_deg = std::max(outcome.worst_deg, d.tail<3>().norm() * 180 / M_PI);
    outcome.off_wall_m = 0;
    for (std::size_t i = 0; i < step.cloud.size(); ++i)
      outcome.off_wall_m += toNearestWall(drive.T_world_base[k] * step.cloud.point(i).cast<double>());
    outcome.off_wall_m /= static_cast<double>(step.cloud.size());
  }
  return outcome;
}

TEST(RadarSurface, CompensatesMotionAndDopplerFromTheFirstSweepOn) {
  for (const double beta : {0.0, 0.049}) {
    const Outcome outcome = driven(*radarSurface(), fastArc(12, beta));
    EXPECT_LT(outcome.worst_m, 0.03) << beta;
    EXPECT_LT(outcome.worst_deg, 0.3) << beta;
    EXPECT_LT(outcome.off_wall_m, 0.03) << beta;
  }
  EXPECT_GT(driven(*radarSurface({"deskew=off"}), fastArc(12, 0)).off_wall_m, 0.1) << "the test sees distortion";
}

TEST(RadarSurface, SaysHowMuchTheDopplerEffectMatters) {
  test::Drive drive = fastArc(12, 0.049);
  for (Scan& scan : drive.scans) {
    auto unaware = std::make_shared<RadarScan>(*scan.radar);
    unaware->doppler_beta_s = 0;
    scan.radar = unaware;
  }
  EXPECT_GT(driven(*radarSurface(), drive).off_wall_m, 0.04);
}

TEST(UndoDoppler, IsTheClosedForm) {
  const Pose T_base_sensor = poseFromYaw(0, {2, 0, 0});
  Cloud cloud;
  for (const auto& [x, y] : {std::pair(12.0f, 0.0f), {-8.0f, 0.0f}, {2.0f, 10.0f}}) cloud.push(x, y, 0);
  const Vector6d twist = (Vector6d() << 10, 0, 0, 0, 0, 0.5).finished();  // the sensor moves at (10, 0.5 * 2)
  undoDoppler(cloud, T_base_sensor, 0.05, twist);
  EXPECT_NEAR(cloud.x[0], 12 + 0.05 * 10, 1e-5) << "ahead looks nearer than it is";
  EXPECT_NEAR(cloud.x[1], -8 + 0.05 * 10, 1e-5) << "behind looks farther";
  EXPECT_NEAR(cloud.y[2], 10 + 0.05 * 1, 1e-5) << "the lever's share";
  cloud.dt = {0, 0, 0.2f};
  const float before = cloud.y[2];
  undoDoppler(cloud, T_base_sensor, 0.05, twist);
  EXPECT_NEAR(cloud.y[2] - before, 0.05 * (1 - 0.2 * 0.5 * 10), 1e-5) << "straight ahead of then is not that of now";
}

TEST(RadarSurface, ARotatedImageGivesTheRotatedMotion) {
  const double turn = 2 * M_PI * 130 / 800;  // by whole azimuths, clockwise
  const Pose T_turn = poseFromYaw(-turn, Eigen::Vector3d::Zero());
  const auto plain = radarSurface(), turned = radarSurface();
  for (std::size_t k = 0; k < 8; ++k) {
    Scan scan = test::radarAt(k, poseFromYaw(0.03 * static_cast<double>(k), {0.2 * static_cast<double>(k) - 3, -1, 0}));
    scan.T_base_sensor = Pose::Identity();
    Scan rotated = scan;
    auto image = std::make_shared<RadarScan>(*scan.radar);
    for (double& angle : image->angles) angle += turn;
    rotated.radar = image;
    transformInPlace(rotated.cloud, T_turn);
    const Pose T = plain->step(scan).T_odom_base, T_rotated = turned->step(rotated).T_odom_base;
    EXPECT_THAT(T_rotated, IsNear(T_turn * T * T_turn.inverse(), 0.01, 0.1)) << k;
  }
}

TEST(RadarSurface, CovarianceStatesWhatTheRadarDoesNotSee) {
  const auto odometry = radarSurface({"climb=0.1", "tilt_deg=2"});
  odometry->step(test::radarAt(0, Pose::Identity()));
  const OdometryStep step = odometry->step(test::radarAt(1, poseFromYaw(0, {0.2, 0, 0})));
  const Matrix6d& C = step.covariance;
  EXPECT_NEAR(std::sqrt(C(2, 2)), 0.01 + 0.1 * 0.2, 2e-3);
  EXPECT_NEAR(std::sqrt(C(3, 3)) * 180 / M_PI, 2, 0.01);
  EXPECT_NEAR(std::sqrt(C(4, 4)) * 180 / M_PI, 2, 0.01);
  for (const int axis : {0, 1, 5}) EXPECT_LT(C(axis, axis), C(2, 2)) << axis;
}

TEST(OrientedPoints, AWallHasADirectionAndAPoleAPlace) {
  Cloud cloud;
  for (int i = -30; i <= 30; ++i) cloud.push(0.1f * static_cast<float>(i), 5.0f + 0.02f * static_cast<float>(i % 2), 0);
  for (int i = 0; i < 8; ++i)
    cloud.push(20.0f + 0.1f * static_cast<float>(i % 3 - 1), 0.1f * static_cast<float>(i % 2), 0);
  const OrientedPoints groups = orientedPoints(cloud, {1.0, 4});
  ASSERT_GT(groups.size(), 5u);
  bool pole = false;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (groups.x[i] > 10) {
      pole = true;
      EXPECT_LT(groups.along[i], 0.02);
    } else {
      EXPECT_GT(std::abs(groups.ny[i]), 0.99);
      EXPECT_LT(groups.across[i], 0.001);
      EXPECT_GT(groups.along[i], 0.05);
    }
  }
  EXPECT_TRUE(pole);
  EXPECT_EQ(orientedPoints(cloud, {1.0, 1000}).size(), 0u);
  EXPECT_EQ(orientedPoints({}, {1.0, 4}).size(), 0u);
}

TEST(OrientedPoints, GroupsStandWhereTheThingIsNotWhereTheCellsAre) {
  for (int shift = 0; shift < 10; ++shift) {
    const float x0 = 20 + 0.1f * static_cast<float>(shift);
    Cloud cloud;
    for (int i = -8; i <= 8; ++i)
      for (int j = -8; j <= 8; ++j)
        if (i * i + j * j <= 64) cloud.push(x0 + 0.1f * static_cast<float>(i), 5.5f + 0.1f * static_cast<float>(j), 0);
    const OrientedPoints groups = orientedPoints(cloud, {1.0, 4});
    ASSERT_GT(groups.size(), 0u);
    for (std::size_t i = 0; i < groups.size(); ++i) EXPECT_NEAR(groups.x[i], x0, 0.05f) << shift;
  }
}

TEST(OrientedPoints, StrongEchoesWeighMore) {
  Cloud cloud;
  for (int i = 0; i < 5; ++i) cloud.push(0.1f, 0.2f * static_cast<float>(i), 0), cloud.intensity.push_back(100);
  for (int i = 0; i < 5; ++i) cloud.push(0.5f, 0.2f * static_cast<float>(i), 0), cloud.intensity.push_back(50);
  const OrientedPoints groups = orientedPoints(cloud, {1.0, 4});
  ASSERT_EQ(groups.size(), 1u);
  EXPECT_NEAR(groups.x[0], (51 * 0.1 + 1 * 0.5) / 52, 1e-4);
}

TEST(OrientedPoints, ArraysOfDifferentLengthsAreRefused) {
  Cloud cloud;
  for (int i = 0; i < 5; ++i) cloud.push(0.1f * static_cast<float>(i), 0, 0);
  OrientedPoints groups = orientedPoints(cloud, {1.0, 4}), read;
  groups.ny.clear();
  ByteWriter state;
  groups.save(state);
  ByteReader reader(state.bytes());
  EXPECT_THROW(read.load(reader), Error);
}

}  // namespace
}  // namespace scslam
