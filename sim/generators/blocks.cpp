// City blocks that all look the same: façades, trees, lamps and even the unevenness of the ground repeat every period,
// to the millimetre. Only landmarks, one per landmark_m along each street, tell places apart.
//
// A grid of columns x rows blocks; streets run along x = i * period and y = j * period and cross there. Routes:
// "around", closed, counter-clockwise around all blocks but the outermost ring, from its south-west corner heading east
// (+x); "grid" up and down all inner streets along x, from the same place.
#include <algorithm>
#include <cmath>

#include "scslam/core/error.h"
#include "sim/props.h"
#include "sim/scenery.h"
#include "sim/world_generator.h"

namespace scslam::sim {
namespace {

using Eigen::Vector3d;

constexpr double kStreet = 12, kRoad = 8, kKerb = 0.12;  // façade to façade, kerb to kerb, height of a kerb [m]

class Blocks : public WorldGenerator {
 public:
  struct Params : ParamSetOf<Params> {
    int columns = 8, rows = 4;
    double period_m = 40, height_m = 12, landmark_m = 200;
    void describe(ParamVisitor& v) override {
      v.field("columns", columns, "blocks along x", 3, 24);
      v.field("rows", rows, "blocks along y", 3, 24);
      v.field("period_m", period_m, "from street to street, a multiple of 4 [m]", 32, 200);
      v.field("height_m", height_m, "of the houses [m]", 3, 60);
      v.field("landmark_m", landmark_m, "from landmark to landmark along a street; 0: none [m]", 0, 1e6);
    }
  };

  Blocks(const Params& params, const PluginContext&) : params_(params) {
    if (std::fmod(params_.period_m, 4) != 0)
      throw usageError("period_m must be a multiple of 4, not {}", params_.period_m);
  }

  World generate(std::uint64_t seed) const override {
    World world;
    world.name = "blocks";
    const Mesh block = oneBlock(seed);
    std::uint16_t things = 0;
    for (const std::uint16_t i : block.instance) things = std::max(things, i);
    std::uint16_t before = 0;
    for (int i = 0; i < params_.columns; ++i)
      for (int j = 0; j < params_.rows; ++j) {
        const std::size_t first = world.mesh.size();
        world.mesh.append(block, poseFromYaw(0, {i * params_.period_m, j * params_.period_m, 0}));
        for (std::size_t k = first; k < world.mesh.size(); ++k)
          if (world.mesh.instance[k] != 0)
            world.mesh.instance[k] = static_cast<std::uint16_t>(world.mesh.instance[k] + before);
        before = static_cast<std::uint16_t>(before + things);
      }
    addLandmarks(world.mesh, seed, before);
    world.routes = {{"around", around(), true}, {"grid", grid(), false}};
    return world;
  }

 private:
  Line around() const {
    const double p = params_.period_m, x1 = (params_.columns - 1) * p, y1 = (params_.rows - 1) * p;
    return {{p, p, 0}, {x1, p, 0}, {x1, y1, 0}, {p, y1, 0}};
  }

  Line grid() const {
    const double p = params_.period_m, x0 = p, x1 = (params_.columns - 1) * p;
    Line line;
    for (int j = 1; j < params_.rows; ++j) {
      const bool east = j % 2 == 1;
      line.emplace_back(east ? x0 : x1, j * p, 0);
      line.emplace_back(east ? x1 : x0, j * p, 0);
    }
    return line;
  }

  /// From the middle of a junction to the middle of the next: half of the streets on all four sides and the houses.
  Mesh oneBlock(std::uint64_t seed) const {
    const double p = params_.period_m, low = kStreet / 2, high = p - kStreet / 2, kerb = kRoad / 2;
    const RoughGround rough(seed, 0.012, p);
    RandomSequence random(CounterRandom(seed, RandomStream::kWorld));
    MeshBuilder builder;
    const auto paved = [&](double x, double y) { return std::min({x, y, p - x, p - y}) > kerb; };
    builder.material("asphalt").terrain(0, 0, p, p, 1, rough, [&](double x, double y) { return !paved(x, y); });
    const Line edge = {{kerb, kerb, 0}, {p - kerb, kerb, 0}, {p - kerb, p - kerb, 0}, {kerb, p - kerb, 0}};
    for (std::size_t k = 0; k < 4; ++k) addKerb(builder, edge[k], edge[(k + 1) % 4]);
    const auto pavement = [&](double x, double y) { return rough(x, y) / 2 + kKerb; };
    builder.material("paving").terrain(kerb, kerb, p - kerb, p - kerb, 1, pavement, [&](double x, double y) {
      return !(x > low && x < high && y > low && y < high);
    });
    addBuilding(builder, low, high);
    const auto at = [&](double x, double y) { return Vector3d(x, y, pavement(x, y)); };
    addTree(builder, at(low - 1, p / 2 + 4), 6.5, random);
    addTree(builder, at(high + 1, p / 2 - 5), 5.5, random);
    addPole(builder, poseFromYaw(-M_PI / 2, at(p / 2 - 6, low - 1.4)), random);
    addPole(builder, poseFromYaw(M_PI / 2, at(p / 2 + 7, high + 1.4)), random);
    addSign(builder, poseFromYaw(M_PI, at(high - 2, low - 1.3)), random);
    addBench(builder, poseFromYaw(-M_PI / 2, at(p / 2 + 2, low - 0.6)), random);
    addBin(builder, poseFromYaw(0, at(low - 0.7, p / 2 - 6)), random);
    return builder.take();
  }

  /// Face, top and a back that dives under the pavement.
  static void addKerb(MeshBuilder& builder, const Vector3d& a, const Vector3d& b) {
    addRibbon(builder.material("kerb"), {a, b}, {0, 0.001, 0.12, 0.6}, {-0.1, kKerb, kKerb, -0.1},
              [](double, double) { return 0.0; });
  }

  void addBuilding(MeshBuilder& builder, double low, double high) const {
    const double h = params_.height_m, middle = (low + high) / 2;
    builder.newInstance();
    addFacade(builder, {low, low, 0}, {high, low, 0}, h, "brick", true);
    addFacade(builder, {high, low, 0}, {high, high, 0}, h, "brick", false);
    addFacade(builder, {high, high, 0}, {low, high, 0}, h, "brick", true);
    addFacade(builder, {low, high, 0}, {low, low, 0}, h, "brick", false);
    builder.material("roof").quad({low, low, h}, {high, low, h}, {high, high, h}, {low, high, h});
    builder.box({middle, middle - 4, h}, 4, 3, 2.2);
    builder.material("plaster");  // balconies to the south, a cornice all around
    for (double z = 3.1; z + 2 < h; z += 3)
      for (const double x : {middle - 8, middle + 8}) builder.box({x, low - 0.45, z}, 2.4, 0.9, 1.0);
    for (const double y : {low - 0.1, high}) builder.box({middle, y, h - 0.35}, high - low + 0.4, 0.2, 0.35);
    builder.noInstance();
  }

  /// One on the pavement of the north-east corner of a junction, every landmark_m along each street along x, shifted by
  /// two blocks from one street to the next.
  void addLandmarks(Mesh& mesh, std::uint64_t seed, std::uint16_t before) const {
    if (params_.landmark_m == 0) return;
    const int every = std::max(1, static_cast<int>(std::lround(params_.landmark_m / params_.period_m)));
    MeshBuilder builder;
    std::uint32_t which = 0;
    for (int j = 0; j < params_.rows; ++j)
      for (int i = 0; i < params_.columns; ++i) {
        if ((i + 2 * j) % every != 1 % every) continue;
        RandomSequence own(CounterRandom(seed, RandomStream::kWorld, 9), which++);
        const Vector3d at(i * params_.period_m + 5.1, j * params_.period_m + 5.1, 0.05);
        builder.newInstance();
        addLandmark(builder, at, own);
      }
    for (std::uint16_t& instance : builder.mesh().instance) instance = static_cast<std::uint16_t>(instance + before);
    mesh.append(builder.mesh());
  }

  /// A sculpture of turned blocks on a plinth: no two are alike.
  static void addLandmark(MeshBuilder& builder, const Vector3d& base, RandomSequence& random) {
    builder.material("concrete").box(base, 1.3, 1.3, random.uniform(0.3, 1.0));
    double z = 0.2;
    const int parts = 4 + random.below(4);
    for (int k = 0; k < parts; ++k) {
      const double height = random.uniform(0.4, 1.4), l = random.uniform(0.4, 1.3), w = random.uniform(0.4, 1.3);
      builder.material(random.below(2) == 0 ? "metal" : "plaster");
      const Vector3d at = base + Vector3d(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), z);
      if (random.below(3) == 0)
        builder.cylinder(at, at + Vector3d(0, 0, height), l / 2, 12);
      else
        builder.box(at, l, w, height, random.uniform(0, M_PI));
      z += height;
    }
    builder.sphere(base + Vector3d(0, 0, z + 0.3), random.uniform(0.3, 0.6), 8);
  }

  Params params_;
};

}  // namespace

SCSLAM_REGISTER(sim::WorldGenerator, sim::Blocks, "blocks",
                "identical city blocks with few landmarks: places that look alike")

}  // namespace scslam::sim
