// Properties every generator of worlds has. What is particular to each: generator_truths_test.cpp.
#include <fmt/ranges.h>

#include <cstring>
#include <memory>
#include <ostream>

#include "worlds.h"

namespace scslam::sim {
namespace {

bool sameBytes(const World& a, const World& b) {
  const auto equal = [](const auto& x, const auto& y) {
    return x.size() == y.size() && (x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof(x[0])) == 0);
  };
  bool same = equal(a.mesh.vertices, b.mesh.vertices) && equal(a.mesh.triangles, b.mesh.triangles) &&
              equal(a.mesh.material, b.mesh.material) && equal(a.mesh.instance, b.mesh.instance) &&
              a.actors.size() == b.actors.size();
  for (std::size_t i = 0; same && i < a.actors.size(); ++i)
    same = equal(a.actors[i].mesh.vertices, b.actors[i].mesh.vertices) && a.actors[i].start_m == b.actors[i].start_m;
  return same;
}

class EveryWorld : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryWorld, IsTheSameForTheSameSeed) { EXPECT_TRUE(sameBytes(make(GetParam()), make(GetParam()))); }

TEST_P(EveryWorld, DiffersFromOneSeedToTheNext) {
  if (GetParam() == "unit") GTEST_SKIP() << "nothing in it is random";
  const std::vector<std::string> settings =
      GetParam() == "corridor" ? std::vector<std::string>{"doors=true"} : std::vector<std::string>{};
  EXPECT_FALSE(sameBytes(make(GetParam(), settings, 1), make(GetParam(), settings, 2)));
}

TEST_P(EveryWorld, HasSoundTrianglesAndMaterials) {
  const World world = make(GetParam());
  expectSound(world.mesh);
  for (const Actor& actor : world.actors) expectSound(actor.mesh);
  EXPECT_LE(world.mesh.size(), 700000U);
  const Eigen::AlignedBox3f box = world.mesh.bounds();
  EXPECT_GT(box.sizes().maxCoeff(), 5);
  EXPECT_LT(box.sizes().maxCoeff(), 5000);
}

/// Every point of every route has ground below and nothing near that stands: what moves keeps clear of the robot.
void expectDrivable(World world) {
  world.actors.clear();
  const RayScene scene(world);
  ASSERT_FALSE(world.routes.empty());
  for (const Route& route : world.routes) {
    SCOPED_TRACE("route " + route.name);
    EXPECT_FALSE(route.name.empty());
    ASSERT_GE(route.points.size(), 2U);
    double nearest = 100;
    for (const Vector3d& p : pointsAlong(route)) {
      const auto ground = scene.first(p + Vector3d(0, 0, 1.5), -Vector3d::UnitZ(), 10);
      ASSERT_TRUE(ground) << "no ground at " << p.transpose();
      ASSERT_NEAR(ground->range, 1.5, 0.5) << "at " << p.transpose();
      const double free = clearance(scene, p + Vector3d(0, 0, kSensor));
      ASSERT_GT(free, 1.0) << "at " << p.transpose();
      nearest = std::min(nearest, free);
    }
    EXPECT_GT(nearest, 1.4);
  }
}

TEST_P(EveryWorld, HasRoutesThatCanBeDriven) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    expectDrivable(make(GetParam(), {}, seed));
  }
}

/// No ray that falls on the ground within 40 m finds a gap.
TEST_P(EveryWorld, HasGroundWithoutGaps) {
  const World world = make(GetParam());
  const RayScene scene(world);
  const auto points = pointsAlong(world.routes[0]);
  for (std::size_t i = 0; i < points.size(); i += 1 + points.size() / 40)
    for (int k = 0; k < 720; ++k) {
      const double a = 2 * M_PI * k / 720;
      for (const double fall : {0.15, 0.4}) {
        const Vector3d d = Vector3d(std::cos(a), std::sin(a), -fall).normalized();
        EXPECT_TRUE(scene.first(points[i] + Vector3d(0, 0, kSensor), d, 400)) << points[i].transpose() << " " << k;
      }
    }
}

/// All but the one that reads a file (mesh_file_test.cpp).
std::vector<std::string> procedural() {
  auto names = Generators::instance().names();
  std::erase(names, "mesh");
  return names;
}

INSTANTIATE_TEST_SUITE_P(Generators, EveryWorld, ::testing::ValuesIn(procedural()),
                         [](const auto& world) { return world.param; });

struct Setting {
  std::string name;
  std::vector<std::string> values;
};
void PrintTo(const Setting& setting, std::ostream* out) {
  *out << setting.name << fmt::format(" {}", fmt::join(setting.values, " "));
}
class AtTheLimits : public ::testing::TestWithParam<Setting> {};

TEST_P(AtTheLimits, WorldIsSoundAndCanBeDriven) {
  const World world = make(GetParam().name, GetParam().values);
  expectSound(world.mesh);
  expectDrivable(world);
}

INSTANTIATE_TEST_SUITE_P(
    Generators, AtTheLimits,
    ::testing::Values(Setting{"corridor", {"length_m=2", "width_m=3", "height_m=2.2", "end_walls=true", "doors=true"}},
                      Setting{"tunnel",
                              {"length_m=20", "radius_m=4.5", "bend_radius_m=30", "pipes=true", "lamps=true"}},
                      Setting{"tunnel", {"length_m=400", "radius_m=15", "bend_radius_m=80"}},
                      Setting{"bridge", {"length_m=30", "clearance_m=3", "lamp_spacing_m=5"}},
                      Setting{"bridge", {"length_m=1000", "lamp_spacing_m=0"}},
                      Setting{"garage", {"levels=1", "occupancy=1"}},
                      Setting{"garage", {"levels=6", "ramp_slope=0.25", "occupancy=0"}},
                      Setting{"garage", {"levels=2", "ramp_slope=0.04", "storey_m=4"}},
                      Setting{"hills", {"height_m=8", "slope=0.08", "trees_per_km=100", "houses=20"}},
                      Setting{"field", {"length_m=60", "width_m=29", "cars=0", "tree_spacing_m=5"}},
                      Setting{"blocks", {"columns=3", "rows=3", "period_m=32", "height_m=3"}},
                      Setting{"roundabout", {"radius_m=14", "arm_m=25", "turns=1"}},
                      Setting{"roundabout", {"radius_m=60", "arm_m=60", "turns=1"}}),
    [](const auto& world) { return fmt::format("{}_{}", world.param.name, world.index); });

}  // namespace
}  // namespace scslam::sim
