// What each world promises, against its closed form.
#include "worlds.h"

namespace scslam::sim {
namespace {

TEST(UnitWorld, CubeIsItsSideAcross) {
  const World world = make("unit", {"size_m=8"});
  const RayScene scene(world);
  const Vector3d sensor(0, 0, kSensor);
  for (const Vector3d& d : {Vector3d(1, 0, 0), Vector3d(-1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, -1, 0)})
    EXPECT_NEAR(scene.first(sensor, d, 100)->range, 4, 1e-5);
  EXPECT_NEAR(scene.first(sensor, {0, 0, 1}, 100)->range, 8 - kSensor, 1e-5);
  EXPECT_NEAR(scene.first(sensor, {0, 0, -1}, 100)->range, kSensor, 1e-5);
}

TEST(UnitWorld, PlaneIsMetAtItsDistanceAndAngle) {
  const World world = make("unit", {"shape=plane", "distance_m=20", "angle_deg=30"});
  const RayScene scene(world);
  const double a = M_PI / 6;
  for (int deg = -25; deg <= 25; deg += 5) {
    const double b = deg * M_PI / 180;
    const auto hit = scene.first({0, 0, kSensor}, {std::cos(b), std::sin(b), 0}, 200);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->range, 20 * std::cos(a) / std::cos(b - a), 1e-3) << deg;
    EXPECT_NEAR(hit->normal.dot(-Vector3d(std::cos(a), std::sin(a), 0)), 1, 1e-5);
  }
}

TEST(UnitWorld, SphereCornerAndReflectorStandWhereTheySay) {
  const World sphere = make("unit", {"shape=sphere", "size_m=2", "distance_m=12"});
  EXPECT_NEAR(RayScene(sphere).first({0, 0, kSensor}, {1, 0, 0}, 100)->range, 10, 0.01);
  const World corner = make("unit", {"shape=corner", "size_m=1", "distance_m=12", "floor=false"});
  const auto apex = RayScene(corner).first({0, 0.001, kSensor - 0.001}, {1, 0, 0}, 100);
  ASSERT_TRUE(apex);
  EXPECT_NEAR(apex->range, 12, 0.01);
  EXPECT_TRUE(apex->surface.material->metal);
  const World reflector = make("unit", {"shape=reflector", "size_m=0.3", "distance_m=12"});
  EXPECT_GT(RayScene(reflector).first({0, 0, kSensor}, {1, 0, 0}, 100)->surface.material->retro, 1);
}

TEST(UnitWorld, MovingWallKeepsItsSpeed) {
  const World world = make("unit", {"shape=moving_wall", "distance_m=15", "speed_mps=4"});
  RayScene scene(world);
  for (const double t : {0.0, 0.5, 3.0}) {
    scene.poseActors(t, t + 0.1);
    EXPECT_NEAR(scene.first({0, 0, kSensor}, {1, 0, 0}, 200, 0)->range, 15 + 4 * t, 1e-3);
    EXPECT_NEAR(scene.first({0, 0, kSensor}, {1, 0, 0}, 200, 1)->range, 15 + 4 * (t + 0.1), 1e-3);
  }
}

TEST(UnitWorld, SkyIsEmpty) {
  const World world = make("unit", {"shape=sky"});
  EXPECT_EQ(clearance(RayScene(world), {0, 0, kSensor}), 100);
}

TEST(Corridor, IsAsWideEverywhereAndOpenAlong) {
  const World world = make("corridor", {"width_m=3.4"});
  const RayScene scene(world);
  for (double x = 0; x <= 200; x += 3.7) {
    for (const double side : {-1.0, 1.0})
      EXPECT_NEAR(scene.first({x, 0, kSensor}, {0, side, 0}, 100)->range, 1.7, 1e-5);
    EXPECT_NEAR(scene.first({x, 0, kSensor}, {0, 0, 1}, 100)->range, 3 - kSensor, 1e-5);
    EXPECT_FALSE(scene.first({x, 0, kSensor}, {1, 0, 0}, 120));
  }
}

TEST(Corridor, DoorsAreTwentyCentimetresDeep) {
  const World world = make("corridor", {"doors=true"});
  const RayScene scene(world);
  int doors = 0;
  for (double x = 0; x <= 200; x += 0.25) {
    const double range = scene.first({x, 0, kSensor}, {0, 1, 0}, 100)->range;
    EXPECT_TRUE(std::abs(range - 1.6) < 1e-4 || std::abs(range - 1.8) < 1e-4) << range;
    doors += range > 1.7;
  }
  EXPECT_GT(doors, 60);
  EXPECT_LT(doors, 200);
}

TEST(Tunnel, HasARoundSection) {
  const World world = make("tunnel", {"bend_radius_m=0", "radius_m=6"});
  const RayScene scene(world);
  const Vector3d middle(300, 0, 1.4);
  for (int deg = -10; deg <= 190; deg += 10) {
    const double a = deg * M_PI / 180;
    EXPECT_NEAR(scene.first(middle, {0, std::cos(a), std::sin(a)}, 100)->range, 6, 0.02) << deg;
  }
  EXPECT_GT(scene.first({40, 0, 10}, {0, 0, 1}, 500) ? 0 : 1, 0) << "the road before it is open";
}

TEST(Tunnel, BendsWithItsRadius) {
  const World world = make("tunnel", {"bend_radius_m=200", "length_m=400"});
  const auto& points = world.routes[0].points;
  // Curvature of the lane, 1.9 m to the right of a left bend.
  const Vector3d &a = points[points.size() / 3 - 8], &b = points[points.size() / 3], &c = points[points.size() / 3 + 8];
  const double area = (b - a).cross(c - a).norm() / 2;
  EXPECT_NEAR((b - a).norm() * (c - b).norm() * (c - a).norm() / (4 * area), 201.9, 1);
  EXPECT_THROW(make("tunnel", {"bend_radius_m=50", "length_m=2000"}), Error);
}

TEST(Tunnel, PipesAndLampsAreOptional) {
  const World bare = make("tunnel"), full = make("tunnel", {"pipes=true", "lamps=true"});
  EXPECT_GT(full.mesh.size(), bare.mesh.size() + 1000);
  expectSound(full.mesh);
}

TEST(Bridge, HasOnlyWaterBesideTheDeck) {
  const World world = make("bridge");
  const RayScene scene(world);
  for (double x = -120; x <= 120; x += 10)
    for (const double side : {-1.0, 1.0})
      for (const double below : {0.05, 0.3, 0.8}) {
        const auto hit = scene.first({x + 1, side * 7, 0.5}, Vector3d(0, side, -below).normalized(), 1000);
        ASSERT_TRUE(hit);
        EXPECT_EQ(hit->surface.material->name, "water");
        EXPECT_NEAR(0.5 - hit->range * below / std::hypot(1, below), -14, 1e-3);
      }
}

TEST(Garage, StoreysAreTheSameHeightAndLookTheSame) {
  const World world = make("garage", {"occupancy=0"});
  const RayScene scene(world);
  for (int level = 0; level < 3; ++level) {
    const double z = 2.8 * level;
    EXPECT_NEAR(scene.first({9, 20, z + 0.5}, {0, 0, 1}, 50)->range, 2.55 - 0.5, 1e-4);
    for (int k = 0; k < 32; ++k) {
      const Vector3d d(std::cos(M_PI * k / 32), -std::sin(M_PI * k / 32), 0.03);  // away from the ramps
      EXPECT_NEAR(scene.first({30, 7.75, z + kSensor}, d.normalized(), 200)->range,
                  scene.first({30, 7.75, kSensor}, d.normalized(), 200)->range, 1e-3);
    }
  }
}

TEST(Garage, RampsHaveTheSlopeAsked) {
  const World world = make("garage", {"ramp_slope=0.15"});
  const RayScene scene(world);
  for (const double y : {14.25, 19.75})
    for (const double x : {2.0, 9.0, 16.0}) {
      const auto hit = scene.first({20 + x, y, 0.15 * x + 1}, {0, 0, -1}, 10);
      EXPECT_NEAR(hit->range, 1, 1e-4);
      EXPECT_NEAR(hit->normal.z(), std::cos(std::atan(0.15)), 1e-5);
    }
  const auto& points = world.routes[0].points;
  double top = 0;
  for (const Vector3d& p : points) top = std::max(top, p.z());
  EXPECT_NEAR(top, 5.6, 1e-9);
}

TEST(Hills, RoadClimbsAsHighAndAsSteepAsAsked) {
  const World world = make("hills");
  double low = 0, high = 0, steepest = 0;
  const auto& points = world.routes[0].points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d step = points[(i + 1) % points.size()] - points[i];
    low = std::min(low, points[i].z()), high = std::max(high, points[i].z());
    steepest = std::max(steepest, std::abs(step.z()) / step.head<2>().norm());
  }
  EXPECT_NEAR(high, 40, 0.5);
  EXPECT_NEAR(low, -40, 0.5);
  EXPECT_NEAR(steepest, 0.08, 0.004);
  EXPECT_THROW(make("hills", {"height_m=2", "slope=0.2"}), Error);
}

TEST(Field, CarsMoveAndKeepOffTheFreeLane) {
  const World world = make("field", {"cars=50"});
  ASSERT_EQ(world.actors.size(), 50U);
  for (const Actor& car : world.actors) {
    EXPECT_GE(car.speed_mps, 5);
    EXPECT_LE(car.speed_mps, 20);
    EXPECT_NE(car.instance, 0);
    EXPECT_NEAR((car.at(0.1).translation() - car.at(0).translation()).norm(), 0.1 * car.speed_mps,
                0.04 * car.speed_mps);
  }
  RayScene scene(world);
  int seen = 0;
  for (double t = 0; t < 60; t += 7) {
    scene.poseActors(t, t);
    for (const Vector3d& p : pointsAlong(world.routes[0])) {
      ASSERT_GT(clearance(scene, p + Vector3d(0, 0, 1)), 1) << "at " << p.transpose() << ", " << t << " s";
      const auto left = scene.first(p + Vector3d(0, 0, 1), {0, 1, 0}, 30);
      seen += left && left->surface.label == movingLabel(Label::kCar);
    }
  }
  EXPECT_GT(seen, 100);
}

TEST(Blocks, RepeatToTheMillimetreExceptForLandmarks) {
  const World world = make("blocks"), plain = make("blocks", {"landmark_m=0"});
  EXPECT_GT(world.mesh.size(), plain.mesh.size());
  const RayScene scene(plain);
  int compared = 0;
  for (int ring = -12; ring <= 8; ring += 4)
    for (int k = 0; k < 180; ++k) {
      const double a = 2 * M_PI * k / 180;
      const Vector3d d = Vector3d(std::cos(a), std::sin(a), ring * M_PI / 180).normalized();
      const auto here = scene.first({91, 80.5, kSensor}, d, 70), there = scene.first({171, 80.5, kSensor}, d, 70);
      ASSERT_EQ(here.has_value(), there.has_value()) << ring << " " << k;
      if (!here) continue;
      EXPECT_NEAR(here->range, there->range, 1e-3) << ring << " " << k;
      ++compared;
    }
  EXPECT_GT(compared, 700);
}

TEST(Blocks, LandmarksAreUniqueAndOnePerStretch) {
  const World world = make("blocks");
  const RayScene scene(world);
  std::vector<double> heights;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 8; ++i) {
      const auto top = scene.first({i * 40 + 5.1, j * 40 + 5.1, 30}, {0, 0, -1}, 29.5);
      if (top) heights.push_back(30 - top->range);
    }
  EXPECT_GE(heights.size(), 5U);
  EXPECT_LE(heights.size(), 8U);
  for (std::size_t i = 0; i < heights.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) EXPECT_GT(std::abs(heights[i] - heights[k]), 1e-3);
}

TEST(Roundabout, IsDrivenAsOftenAsAsked) {
  const World world = make("roundabout", {"turns=3"});
  double turned = 0;
  const auto& points = world.routes[0].points;
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const Vector3d a = points[i] - points[i - 1], b = points[i + 1] - points[i];
    turned += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  }
  EXPECT_NEAR(turned, 2 * M_PI * 3, 1e-6);
  EXPECT_NEAR(world.routes[1].points[3].norm(), 20, 1e-9);
}

}  // namespace
}  // namespace scslam::sim
