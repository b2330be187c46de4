// A long straight corridor with smooth, parallel walls: nothing tells how far along one is.
//
// It runs along x, its middle at y = 0, floor z = 0; it goes on for margin_m beyond both ends of the route, so that the
// end is out of sight. Route "along": from x = 0 to length_m.
#include "scslam/core/error.h"
#include "sim/mesh_builder.h"
#include "sim/world_generator.h"

namespace scslam::sim {
namespace {

using Eigen::Vector3d;

class Corridor : public WorldGenerator {
 public:
  struct Params : ParamSetOf<Params> {
    double length_m = 200, width_m = 3.2, height_m = 3, margin_m = 130;
    bool doors = false, end_walls = false;
    void describe(ParamVisitor& v) override {
      v.field("length_m", length_m, "of the route [m]", 2, 5000);
      v.field("width_m", width_m, "between the walls [m]", 3, 50);
      v.field("height_m", height_m, "of the ceiling [m]", 2.2, 50);
      v.field("margin_m", margin_m, "the corridor goes on for this much beyond both ends of the route [m]", 2, 500);
      v.field("doors", doors, "doors 20 cm deep in both walls, at random every 4 to 9 m");
      v.field("end_walls", end_walls, "whether walls close it at both ends");
    }
  };

  Corridor(const Params& params, const PluginContext&) : params_(params) {}

  World generate(std::uint64_t seed) const override {
    const double x0 = -params_.margin_m, x1 = params_.length_m + params_.margin_m, w = params_.width_m / 2;
    const double h = params_.height_m;
    const int pieces = std::max(1, static_cast<int>((x1 - x0) / 5));
    const auto x = [&](int i) { return x0 + (x1 - x0) * i / pieces; };
    MeshBuilder builder;
    builder.material("concrete");
    builder.patch(pieces, 1, [&](int i, int j) { return Vector3d(x(i), j == 0 ? -w : w, 0); });
    builder.material("plaster");
    builder.patch(pieces, 1, [&](int i, int j) { return Vector3d(x(i), j == 0 ? w : -w, h); });
    for (const double side : {-1.0, 1.0})
      addWall(builder, side, RandomSequence(CounterRandom(seed, RandomStream::kWorld), side < 0 ? 1 : 2));
    if (params_.end_walls) {
      builder.quad({x1, w, 0}, {x1, -w, 0}, {x1, -w, h}, {x1, w, h});
      builder.quad({x0, -w, 0}, {x0, w, 0}, {x0, w, h}, {x0, -w, h});
    }
    World world;
    world.name = "corridor";
    world.mesh = builder.take();
    world.routes = {{"along", {{0, 0, 0}, {params_.length_m, 0, 0}}, false}};
    return world;
  }

 private:
  /// The wall at y = side * width / 2.
  void addWall(MeshBuilder& builder, double side, RandomSequence random) const {
    constexpr double kDoor = 1.0, kLintel = 2.05, kDeep = 0.2;
    const double x1 = params_.length_m + params_.margin_m, y = side * params_.width_m / 2;
    const auto face = [&](double a, double b, double z0, double z1, double deep) {
      const double wall = y + side * deep;
      if (side > 0)
        builder.quad({b, wall, z0}, {a, wall, z0}, {a, wall, z1}, {b, wall, z1});
      else
        builder.quad({a, wall, z0}, {b, wall, z0}, {b, wall, z1}, {a, wall, z1});
    };
    double at = -params_.margin_m;
    while (at < x1) {
      const double next = std::min(x1, at + (params_.doors ? random.uniform(4, 9) : 5.0));
      const bool has_door = params_.doors && next - at > 2 * kDoor;
      const double wall_end = has_door ? next - kDoor : next;
      builder.material("plaster");
      face(at, wall_end, 0, params_.height_m, 0);
      if (has_door) {
        face(wall_end, next, kLintel, params_.height_m, 0);
        builder.quad({wall_end, y, 0}, {wall_end, y + side * kDeep, 0}, {wall_end, y + side * kDeep, kLintel},
                     {wall_end, y, kLintel});
        builder.quad({next, y, 0}, {next, y + side * kDeep, 0}, {next, y + side * kDeep, kLintel}, {next, y, kLintel});
        builder.quad({wall_end, y, kLintel}, {next, y, kLintel}, {next, y + side * kDeep, kLintel},
                     {wall_end, y + side * kDeep, kLintel});
        builder.material("wood");
        face(wall_end, next, 0, kLintel, kDeep);
      }
      at = next;
    }
  }

  Params params_;
};

}  // namespace

SCSLAM_REGISTER(sim::WorldGenerator, sim::Corridor, "corridor",
                "straight corridor with smooth walls: its axis cannot be observed")

}  // namespace scslam::sim
