// The LiDAR against what can be worked out by hand.
#include "sim/lidar.h"

#include <cmath>
#include <map>

#include "scslam/sensor/sensor_tables.h"
#include "sim/mesh_builder.h"
#include "support/support.h"

namespace scslam::sim {
namespace {

using Eigen::Vector3d;

/// Drives straight along x from the origin.
Trajectory straight(double speed) {
  std::vector<Pose> control;
  for (int k = -1; k < 30; ++k) control.push_back(poseFromYaw(0, {speed * 0.1 * k, 0, 0}));
  return Trajectory(control, 0.1);
}

/// Effects that change nothing of the truth.
LidarEffects pure() {
  LidarEffects effects;
  effects.noise = effects.dropout = effects.beam_width = false;
  return effects;
}

World wallAt(double x, double half = 200) {
  MeshBuilder b;
  b.material("white");
  b.quad({x, half, -half}, {x, half, half}, {x, -half, half}, {x, -half, -half});
  World world;
  world.name = "wall", world.mesh = b.take();
  return world;
}

struct Sweeper {
  explicit Sweeper(World w) : world(std::move(w)), scene(world) {}
  LidarScan operator()(Lidar& lidar, double speed = 0, std::uint32_t number = 0, int thread_count = 1) {
    ThreadPool threads(thread_count);
    scene.poseActors(0, lidar.grid().sweep());
    return lidar.scan(scene, straight(speed), 0, number, threads);
  }
  World world;
  RayScene scene;
};

TEST(Lidar, SeesACubeAsItIs) {
  MeshBuilder b;
  b.box(Vector3d(0, 0, -5), 10, 10, 10);
  World world;
  world.mesh = b.take();
  for (const std::string name : {"vlp16", "os1-64", "mulran_os1-64", "os1-128", "hdl64"}) {
    Sweeper run(world);
    const SensorModel sensor = loadSensorModel(name);
    SensorModel at_origin = sensor;
    at_origin.translation_m = at_origin.rpy_deg = {0, 0, 0}, at_origin.min_range_m = 0;
    Lidar lidar(at_origin, pure(), {}, 1);
    const LidarScan scan = run(lidar);
    std::size_t active = 0;
    for (int c = 0; c < sensor.columns; ++c)
      for (int r = 0; r < sensor.rings; ++r) active += lidar.grid().isActive(c, r);
    ASSERT_EQ(scan.cloud.size(), active) << name;
    for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
      const float far = scan.cloud.point(i).cwiseAbs().maxCoeff();
      ASSERT_NEAR(far, 5, 2e-4) << name << ": a point on no face";
    }
  }
}

TEST(Lidar, KnowsRingAndTimeOfEachBeam) {
  Sweeper run(wallAt(30));
  SensorModel sensor = loadSensorModel("vlp16");
  sensor.beams.height_m.clear();
  Lidar lidar(sensor, pure(), {}, 1);
  const LidarScan scan = run(lidar);
  ASSERT_GT(scan.cloud.size(), 1000u);
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    const Vector3d p = scan.cloud.point(i).cast<double>();
    const double elevation = std::atan2(p.z(), std::hypot(p.x(), p.y())) * 180 / M_PI;
    ASSERT_NEAR(elevation, -15 + 2.0 * scan.cloud.ring[i], 1e-3);
    // dt = 55.296 us column + 2.304 us laser; the head turns clockwise, steadily.
    const int ring = scan.cloud.ring[i], laser = ring < 8 ? 2 * ring : 2 * (ring - 8) + 1;
    const double after = static_cast<double>(scan.cloud.dt[i]) - 2.304e-6 * laser;
    const double column = std::round(after / 55.296e-6);
    ASSERT_NEAR(after, column * 55.296e-6, 2e-8);
    const double azimuth = -2 * M_PI / 1808 * (static_cast<double>(scan.cloud.dt[i]) / 55.296e-6);
    ASSERT_NEAR(std::remainder(std::atan2(p.y(), p.x()) - azimuth, 2 * M_PI), 0, 1e-5);
  }
}

TEST(Lidar, MeasuresASlantedPlane) {
  // The wall stands 10 m ahead of a sensor that is turned by 25 degrees.
  Sweeper run(wallAt(10));
  SensorModel sensor = loadSensorModel("mulran_os1-64");
  sensor.translation_m = {0, 0, 0}, sensor.rpy_deg = {0, 0, 25}, sensor.beams.blind_deg.clear();
  Lidar lidar(sensor, pure(), {}, 1);
  const LidarScan scan = run(lidar);
  ASSERT_GT(scan.cloud.size(), 10000u);
  const Pose T = sensor.T_base_sensor();
  for (std::size_t i = 0; i < scan.cloud.size(); ++i)
    ASSERT_NEAR((T * scan.cloud.point(i).cast<double>()).x(), 10,
                10 * 2e-5 * static_cast<double>(scan.cloud.point(i).norm()));
}

TEST(Lidar, SeesTheClosedFormShapeOfAMovingWallFromAMovingRobot) {
  constexpr double kWall = 20, kWallSpeed = -6, kSpeed = 15;
  World world = wallAt(-100);  // something that stands, behind
  Actor wall;
  MeshBuilder b;
  b.quad({0, 200, -200}, {0, 200, 200}, {0, -200, 200}, {0, -200, -200});
  wall.mesh = b.take();
  wall.path = {{1000, 0, 0}, {-1000, 0, 0}};
  wall.speed_mps = -kWallSpeed, wall.start_m = 1000 - kWall, wall.loops = false;
  world.actors.push_back(wall);
  Sweeper run(world);
  SensorModel sensor = loadSensorModel("os1-64");
  sensor.beams.origin_radius_m = 0;
  Lidar lidar(sensor, pure(), {}, 1);
  const LidarScan scan = run(lidar, kSpeed);
  std::size_t on_wall = 0;
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    const Vector3d p = scan.cloud.point(i).cast<double>();
    if (p.x() < 1 || scan.labels[i] % 65536 < 250) continue;
    const auto t = static_cast<double>(scan.cloud.dt[i]);
    // In the sensor's frame at its firing time the wall is the gap ahead: 20 m, closing by 21 m/s.
    ASSERT_NEAR(p.x(), kWall + (kWallSpeed - kSpeed) * t, 1e-3) << "after " << t << " s";
    ++on_wall;
  }
  EXPECT_GT(on_wall, 5000u);
}

TEST(Lidar, NoiseIsAsTheTableSays) {
  Sweeper run(wallAt(30, 60));
  SensorModel sensor = loadSensorModel("os1-64");
  sensor.beams.origin_radius_m = 0, sensor.beams.range_quantum_m = 0.001;
  LidarEffects effects = pure();
  Lidar exact(sensor, effects, {}, 1);
  run(exact);
  effects.noise = true;
  Lidar noisy(sensor, effects, {}, 1);
  const LidarScan scan = run(noisy);
  double sum = 0, sum2 = 0;
  std::size_t n = 0, i = 0;
  for (int c = 0; c < sensor.columns; ++c)
    for (int r = 0; r < sensor.rings; ++r) {
      const auto& echo = exact.echoes()[static_cast<std::size_t>(c * sensor.rings + r)];
      if (echo.range <= 0) continue;
      const auto range = static_cast<double>(echo.range);
      const double z = (static_cast<double>(scan.cloud.point(i).norm()) - range) / (0.014 + 0.0015 * range);
      sum += z, sum2 += z * z, ++n, ++i;
    }
  ASSERT_EQ(i, scan.cloud.size());
  const auto count = static_cast<double>(n);
  EXPECT_NEAR(sum / count, 0, 3 / std::sqrt(count));
  EXPECT_NEAR(sum2 / count, 1, 3 * std::sqrt(2 / count));
}

TEST(Lidar, LosesEchoesAsTheirStrengthSays) {
  Sweeper run(wallAt(25, 100));
  SensorModel sensor = loadSensorModel("os1-64");
  sensor.signal.gain = 20000;
  LidarEffects effects = pure();
  Lidar all(sensor, effects, {}, 1);
  run(all);
  effects.dropout = true;
  Lidar lossy(sensor, effects, {}, 1);
  const SignalModel& s = sensor.signal;
  double expected = 0, variance = 0, lost = 0;
  for (std::uint32_t number = 0; number < 4; ++number) {
    const LidarScan scan = run(lossy, 0, number);
    double hits = 0;
    for (const auto& echo : all.echoes()) {
      if (echo.range <= 0) continue;
      ++hits;
      const auto strength = static_cast<double>(echo.signal);
      const double p =
          strength < s.floor
              ? 1
              : std::min(s.dropout_most,
                         s.dropout_base + s.dropout_scale * std::pow(s.dropout_signal / strength, s.dropout_power));
      expected += p, variance += p * (1 - p);
    }
    lost += hits - static_cast<double>(scan.cloud.size());
  }
  EXPECT_GT(expected, 300);
  EXPECT_NEAR(lost, expected, 3 * std::sqrt(variance));
}

TEST(Lidar, StrengthFollowsRangeAndIncidence) {
  SensorModel sensor = loadSensorModel("os1-64");
  sensor.beams.origin_radius_m = 0, sensor.elevation_deg[32] = 0;
  std::map<int, double> signal;
  for (const int distance : {20, 40}) {
    Sweeper run(wallAt(distance));
    Lidar lidar(sensor, pure(), {}, 1);
    run(lidar);
    for (int c = 0; c < sensor.columns; ++c) {
      const auto& echo = lidar.echoes()[static_cast<std::size_t>(c * sensor.rings + 32)];
      if (echo.range <= 0) continue;
      const double cosine = distance / static_cast<double>(echo.range);
      const double expected = 0.9 * cosine * sensor.signal.gain / std::pow(static_cast<double>(echo.range), 2);
      ASSERT_NEAR(static_cast<double>(echo.signal), expected, 1e-3 * expected);
    }
  }
}

/// A post of 4 cm before a wall: thinner than the beam.
World postBeforeWall() {
  World world = wallAt(30);
  MeshBuilder b;
  b.material("white");
  b.box({12, 0, -10}, 0.02, 0.04, 20);
  world.mesh.append(b.take());
  return world;
}

TEST(Lidar, ASplitBeamHasTwoEchoes) {
  Sweeper run(postBeforeWall());
  SensorModel sensor = loadSensorModel("os1-64");
  sensor.beams.divergence_mrad = 6;
  LidarEffects effects = pure();
  effects.beam_width = true;
  Lidar strongest(sensor, effects, {}, 1);
  const LidarScan single = run(strongest);
  effects.returns = "dual";
  Lidar dual(sensor, effects, {}, 1);
  const LidarScan both = run(dual);
  effects.returns = "last";
  Lidar last(sensor, effects, {}, 1);
  const LidarScan far = run(last);
  EXPECT_GT(both.cloud.size(), single.cloud.size());
  EXPECT_EQ(far.cloud.size(), single.cloud.size());
  const auto near = [](const LidarScan& scan) {
    std::size_t n = 0;
    for (const float x : scan.cloud.x) n += x > 5 && x < 13;
    return n;
  };
  EXPECT_GT(near(single), near(far)) << "the last echo is the wall's";
}

TEST(Lidar, FogShortensAndAnswersItself) {
  Sweeper run(wallAt(40));
  const SensorModel sensor = loadSensorModel("os1-64");
  LidarEffects effects;
  Lidar clear(sensor, effects, {}, 1);
  Weather fog;
  fog.fog_per_m = 0.06;
  Lidar foggy(sensor, effects, fog, 1);
  const LidarScan a = run(clear), b = run(foggy);
  const auto beyond = [](const LidarScan& scan, float x) {
    return std::count_if(scan.cloud.x.begin(), scan.cloud.x.end(), [x](float v) { return v > x; });
  };
  EXPECT_LT(beyond(b, 35), beyond(a, 35) / 2);
  EXPECT_GT(std::count(b.labels.begin(), b.labels.end(), 1u), 100);
  EXPECT_EQ(std::count(a.labels.begin(), a.labels.end(), 1u), 0);
}

TEST(Lidar, GivesTheSameBytesForAnyNumberOfThreads) {
  Sweeper run(postBeforeWall());
  for (const std::string name : {"os1-64", "vlp16", "hdl64", "utm30"}) {
    const SensorModel sensor = loadSensorModel(name);
    Lidar one(sensor, {}, {}, 7), two(sensor, {}, {}, 7), other(sensor, {}, {}, 8);
    const LidarScan a = run(one, 10, 3, 1), b = run(two, 10, 3, 2), c = run(other, 10, 3, 1);
    EXPECT_EQ(a.cloud.x, b.cloud.x) << name;
    EXPECT_EQ(a.cloud.dt, b.cloud.dt);
    EXPECT_EQ(a.labels, b.labels);
    EXPECT_NE(a.cloud.x, c.cloud.x) << name;
    ASSERT_FALSE(a.cloud.empty()) << name;
  }
}

TEST(Lidar, RefusesTablesThatCannotBeSimulated) {
  SensorModel sensor = loadSensorModel("sick_lms");
  EXPECT_THROW(Lidar(sensor, {}, {}, 1), Error);
  sensor = loadSensorModel("vlp16");
  sensor.elevation_deg.pop_back();
  EXPECT_THROW(Lidar(sensor, {}, {}, 1), Error);
}

}  // namespace
}  // namespace scslam::sim
