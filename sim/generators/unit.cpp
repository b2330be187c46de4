// Unit worlds: one shape each, with closed-form answers for every ray.
//
// The floor is z = 0, 100 m to each side (not for "cube" and "sky"); shapes stand `distance_m` along +x, targets that
// are small have their middle at z = height_m. Route "stand": from the origin 1 m towards +x.
#include <algorithm>

#include "scslam/core/error.h"
#include "sim/mesh_builder.h"
#include "sim/world_generator.h"

namespace scslam::sim {
namespace {

using Eigen::Vector3d;

class UnitWorld : public WorldGenerator {
 public:
  struct Params : ParamSetOf<Params> {
    std::string shape = "cube", material = "white";
    double size_m = 10, distance_m = 10, angle_deg = 0, height_m = 1.7, speed_mps = 5;
    bool floor = true;
    void describe(ParamVisitor& v) override {
      v.field("shape", shape,
              "cube: a room of side size_m around the sensor; plane; sphere of radius size_m; corner: trihedral "
              "reflector with edges of size_m; reflector: a retro-reflecting square of side size_m; moving_wall: a "
              "plane that drives away; sky: nothing at all",
              {"cube", "plane", "sphere", "corner", "reflector", "moving_wall", "sky"});
      v.field("material", material, "of cube, plane, sphere and moving_wall (corners are metal)");
      v.field("size_m", size_m, "side, radius or edge [m]", 0.01, 1000);
      v.field("distance_m", distance_m, "from the origin to the plane or to the middle of the shape [m]", 1.5, 1000);
      v.field("angle_deg", angle_deg, "the plane's normal is turned this far from -x about z [deg]", -85, 85);
      v.field("height_m", height_m, "of the middle of sphere, corner and reflector [m]", -1000, 1000);
      v.field("speed_mps", speed_mps, "of the moving wall, away from the origin [m/s]", 0, 60);
      v.field("floor", floor, "whether there is a floor");
    }
  };

  UnitWorld(const Params& params, const PluginContext&) : params_(params) { materialIndex(params_.material); }

  World generate(std::uint64_t) const override {
    const Params& p = params_;
    if (p.shape == "cube" && p.size_m < 3.2)
      throw usageError("a cube of {} m has no room for a sensor: size_m >= 3.2", p.size_m);
    MeshBuilder builder;
    World world;
    world.name = p.shape;
    world.routes = {{"stand", {Vector3d::Zero(), Vector3d::UnitX()}, false}};
    if (p.floor && p.shape != "cube" && p.shape != "sky")
      builder.material("asphalt").terrain(-100, -100, 100, 100, 10, [](double, double) { return 0.0; });
    builder.material(p.material);
    const Vector3d middle(p.distance_m, 0, p.height_m);
    if (p.shape == "cube") room(builder);
    if (p.shape == "plane") plane(builder, p.distance_m, p.angle_deg * M_PI / 180);
    if (p.shape == "sphere") builder.sphere(middle, p.size_m, 64);
    if (p.shape == "corner") corner(builder, middle);
    if (p.shape == "reflector") square(builder.material("retro_reflector"), middle);
    if (p.shape == "moving_wall") world.actors.push_back(movingWall());
    if (builder.mesh().empty())  // a world is never quite empty
      builder.triangle({0, 0, -10000}, {0.1, 0, -10000}, {0, 0.1, -10000});
    world.mesh = builder.take();
    return world;
  }

 private:
  void room(MeshBuilder& builder) const {
    const double h = params_.size_m / 2, z = params_.size_m;
    builder.quad({-h, -h, 0}, {h, -h, 0}, {h, h, 0}, {-h, h, 0});
    builder.quad({-h, -h, z}, {-h, h, z}, {h, h, z}, {h, -h, z});
    builder.quad({h, -h, 0}, {h, -h, z}, {h, h, z}, {h, h, 0});
    builder.quad({-h, h, 0}, {-h, h, z}, {-h, -h, z}, {-h, -h, 0});
    builder.quad({h, h, 0}, {h, h, z}, {-h, h, z}, {-h, h, 0});
    builder.quad({-h, -h, 0}, {-h, -h, z}, {h, -h, z}, {h, -h, 0});
  }

  /// 200 m wide, 100 m high and deep, in pieces of 5 m; (distance, 0, z) is on it.
  static void plane(MeshBuilder& builder, double distance, double angle) {
    const Vector3d across(-std::sin(angle), std::cos(angle), 0);
    builder.patch(
        40, 40, [&](int i, int j) { return Vector3d(Vector3d(distance, 0, -100 + 5 * i) + across * (-100 + 5 * j)); });
  }

  void corner(MeshBuilder& builder, const Vector3d& apex) const {
    // Edges of a cube that stands on its corner, opening towards -x.
    const double a = params_.size_m, s = a / std::sqrt(3.0), t = a * std::sqrt(2.0 / 3.0);
    Vector3d edge[3];
    for (int k = 0; k < 3; ++k) {
      const double angle = 2 * M_PI * k / 3 + M_PI / 2;
      edge[k] = apex + Vector3d(-s, t * std::cos(angle), t * std::sin(angle));
    }
    builder.material("metal");
    for (int k = 0; k < 3; ++k) builder.triangle(apex, edge[(k + 1) % 3], edge[k]);
  }

  void square(MeshBuilder& builder, const Vector3d& middle) const {
    const double h = params_.size_m / 2;
    builder.quad(middle + Vector3d(0, h, -h), middle + Vector3d(0, -h, -h), middle + Vector3d(0, -h, h),
                 middle + Vector3d(0, h, h));
  }

  Actor movingWall() const {
    constexpr double kReach = 1.5;  // an actor's middle is at start_m of its path, this much from either end
    MeshBuilder builder;
    plane(builder.material(params_.material), 0, 0);
    Actor wall;
    wall.mesh = builder.take();
    wall.label = Label::kOtherObject;
    wall.instance = 1;
    wall.path = {{params_.distance_m - kReach, 0, 0}, {params_.distance_m + 10000, 0, 0}};
    wall.speed_mps = params_.speed_mps;
    wall.start_m = kReach;
    wall.loops = false;
    return wall;
  }

  Params params_;
};

}  // namespace

SCSLAM_REGISTER(sim::WorldGenerator, sim::UnitWorld, "unit",
                "one shape with closed-form ranges: cube, plane, sphere, corner, reflector, moving wall, empty sky")

}  // namespace scslam::sim
