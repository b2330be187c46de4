// Open country by a river: a very wide, straight road full of traffic, few trees and poles.
//
// The road runs along x from -length/2 to +length/2 and ends in round places; four lanes each way, right-hand traffic.
// The second lane from the middle (y = -/+ ego lane) is kept free of others. Routes: "there_and_back", closed, from the
// western end heading east (+x); "along", one way.
#include <algorithm>
#include <cmath>

#include "sim/props.h"
#include "sim/scenery.h"
#include "sim/world_generator.h"

namespace scslam::sim {
namespace {

using Eigen::Vector3d;

constexpr double kMedian = 5;  // half of it is beside each innermost lane [m]
constexpr int kLanes = 4, kEgoLane = 1;

class Field : public WorldGenerator {
 public:
  struct Params : ParamSetOf<Params> {
    int cars = 40;
    double length_m = 600, width_m = 33, min_speed_mps = 5, max_speed_mps = 20, tree_spacing_m = 35;
    void describe(ParamVisitor& v) override {
      v.field("cars", cars, "that drive, round and round, in the lanes beside the free one", 0, 2000);
      v.field("length_m", length_m, "of the road [m]", 60, 5000);
      v.field("width_m", width_m, "of the road, with a median of 5 m [m]", 29, 80);
      v.field("min_speed_mps", min_speed_mps, "of the cars in the outermost lane [m/s]", 0, 60);
      v.field("max_speed_mps", max_speed_mps, "of the cars in the innermost lane [m/s]", 0, 60);
      v.field("tree_spacing_m", tree_spacing_m, "between trees, on each side [m]", 5, 10000);
    }
  };

  Field(const Params& params, const PluginContext&) : params_(params) {}

  World generate(std::uint64_t seed) const override {
    const RoughGround rough(seed, 0.02);
    RandomSequence random(CounterRandom(seed, RandomStream::kWorld));
    MeshBuilder builder;
    addGround(builder, rough);
    addThings(builder, rough, random);
    World world;
    world.name = "field";
    RandomSequence traffic(CounterRandom(seed, RandomStream::kActors));
    world.actors = cars(builder, traffic);
    world.mesh = builder.take();
    const double y = laneY(kEgoLane), x = params_.length_m / 2;
    world.routes = {{"there_and_back", loop(kEgoLane), true}, {"along", {{-x, -y, 0}, {x, -y, 0}}, false}};
    return world;
  }

 private:
  double laneWidth() const { return (params_.width_m - kMedian) / (2 * kLanes); }
  double laneY(int lane) const { return kMedian / 2 + laneWidth() * (lane + 0.5); }
  double end() const { return params_.length_m / 2; }

  /// Along a lane eastwards, around the eastern place, back and around the western one.
  Line loop(int lane) const {
    const double y = laneY(lane);
    Line line = arc({end(), 0, 0}, y, -90, 90, 3);
    const Line west = arc({-end(), 0, 0}, y, 90, 270, 3);
    line.insert(line.end(), west.begin(), west.end());
    std::rotate(line.begin(), line.end() - 1, line.end());
    return line;
  }

  void addGround(MeshBuilder& builder, const RoughGround& rough) const {
    const double half = params_.width_m / 2, x1 = end() + half + 20, far = half + 90;
    const auto distance = [&](double x, double y) { return std::hypot(std::max(0.0, std::abs(x) - end()), y); };
    const auto isMedian = [&](double x, double y) {
      return std::abs(x) < end() - 4 && std::abs(y) < kMedian / 2 - 0.9;
    };
    const auto isRoad = [&](double x, double y) { return distance(x, y) < half && !isMedian(x, y); };
    const auto ground = [&](double x, double y) {
      const double off = std::max(0.0, distance(x, y) - half);
      return rough(x, y) * (off > 0 || isMedian(x, y) ? 1.6 : 0.7) + 0.4 * std::sin(x / 23) * std::min(1.0, off / 40);
    };
    // Fine cells near the road dive under the coarse ones, which dive under the fine ones: no gaps.
    const double near = std::ceil(half + 8);
    const auto fine = [&](double x, double y) { return ground(x, y) - (std::abs(y) > near ? 0.3 : 0); };
    const auto coarse = [&](double x, double y) { return ground(x, y) - (std::abs(y) < near ? 0.3 : 0); };
    builder.material("asphalt").terrain(-x1, -near - 1, x1, near + 1, 1, fine, isRoad);
    builder.material("grass");
    builder.terrain(-x1, -near - 1, x1, near + 1, 1, fine, [&](double x, double y) { return !isRoad(x, y); });
    builder.terrain(-x1, near - 4, x1, far, 4, coarse);
    builder.terrain(-x1, -near - 45, x1, -near + 4, 4, coarse);
    builder.material("water");  // the river, to the south, behind its bank
    builder.terrain(-x1 - 200, -near - 400, x1 + 200, -near - 45, 50, [](double, double) { return -2.5; });
    builder.material("soil");
    builder.patch(static_cast<int>(x1 / 4), 2, [&](int i, int j) {
      const double x = -x1 + 2 * x1 * i / static_cast<int>(x1 / 4);
      return Vector3d(x, -near - 49 + 2 * j, j == 2 ? ground(x, -near - 45) : -2.7 + 1.2 * j);
    });
  }

  void addThings(MeshBuilder& builder, const RoughGround& rough, RandomSequence& random) const {
    const double half = params_.width_m / 2;
    const auto at = [&](double x, double y) { return Vector3d(x, y, rough(x, y)); };
    for (const double side : {-1.0, 1.0}) {
      for (double x = -end(); x < end(); x += params_.tree_spacing_m) {
        const double height = random.uniform(5, 12), out = half + 4.5 + random.uniform(0, 20);
        addTree(builder, at(x + random.uniform(0, 0.8) * params_.tree_spacing_m, side * out), height, random);
      }
      for (double x = -end() + 30; x < end(); x += 70)
        addPole(builder, poseFromYaw(-side * M_PI / 2, at(x, side * (half + 1.5))), random);
    }
    for (double x = -end() + 50; x < end() - 20; x += 150)
      addSign(builder, poseFromYaw(M_PI, at(x, -half - 1.5)), random);
  }

  std::vector<Actor> cars(MeshBuilder& world, RandomSequence& random) const {
    std::vector<Actor> result;
    const int lanes[] = {0, 2, 3};
    for (int k = 0; k < 3; ++k) {
      const int count = (params_.cars + 2 - k) / 3;
      Actor car;
      car.path = loop(lanes[k]);
      car.path.push_back(car.path.front());
      car.speed_mps = params_.max_speed_mps + (params_.min_speed_mps - params_.max_speed_mps) * k / 2;
      for (int i = 0; i < count; ++i) {
        MeshBuilder builder;
        addCar(builder, Pose::Identity(), random);
        car.mesh = builder.take();
        car.label = Label::kCar;
        car.instance = world.newInstance().instance();
        car.start_m = car.pathLength() * (i + random.uniform(0.1, 0.6)) / count;
        result.push_back(car);
      }
    }
    world.noInstance();
    return result;
  }

  Params params_;
};

}  // namespace

SCSLAM_REGISTER(sim::WorldGenerator, sim::Field, "field",
                "open country: wide road, many moving cars, sparse trees and poles")

}  // namespace scslam::sim
