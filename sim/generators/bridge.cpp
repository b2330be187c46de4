// A long bridge: deck and rails, water far below, trees and houses only on the banks.
//
// The deck runs along x from -length/2 to +length/2, its road surface at z = 0, y = 0 in the middle; the road goes on
// for 130 m on each bank. Routes: "across" from the western bank heading east (+x) in the right-hand lane;
// "there_and_back", closed, turning on a round place on each bank.
#include <algorithm>
#include <cmath>

#include "scslam/core/error.h"
#include "sim/props.h"
#include "sim/scenery.h"
#include "sim/world_generator.h"

namespace scslam::sim {
namespace {

using Eigen::Vector3d;

constexpr double kHalf = 5.5, kLane = 2.75, kBank = 130, kPlace = 95, kPlaceRadius = 17;  // [m]

class Bridge : public WorldGenerator {
 public:
  struct Params : ParamSetOf<Params> {
    double length_m = 300, clearance_m = 14, lamp_spacing_m = 60;
    void describe(ParamVisitor& v) override {
      v.field("length_m", length_m, "of the deck [m]", 30, 5000);
      v.field("clearance_m", clearance_m, "from the water up to the road [m]", 3, 200);
      v.field("lamp_spacing_m", lamp_spacing_m, "between lamp posts on the deck, on its north side; 0: none [m]", 0,
              1000);
    }
  };

  Bridge(const Params& params, const PluginContext&) : params_(params) {
    if (params_.lamp_spacing_m != 0 && params_.lamp_spacing_m < 5)
      throw usageError("lamp posts stand at least 5 m apart (0: none), not {} m", params_.lamp_spacing_m);
  }

  World generate(std::uint64_t seed) const override {
    const double half = params_.length_m / 2;
    const RoughGround rough(seed, 0.012);
    RandomSequence random(CounterRandom(seed, RandomStream::kWorld));
    MeshBuilder builder;
    addDeck(builder, rough, random);
    for (const double side : {-1.0, 1.0}) addBank(builder, side, rough, random);
    builder.material("water");
    const double reach = half + kBank + 60;
    builder.terrain(-reach, -400, reach, 400, 40, [&](double, double) { return -params_.clearance_m; });
    World world;
    world.name = "bridge";
    world.mesh = builder.take();
    const double x = half + kPlace - kPlaceRadius, far = half + kPlace + 11;
    world.routes = {{"across", {{-x, -kLane, 0}, {x, -kLane, 0}}, false},
                    {"there_and_back",
                     {{-x, -kLane, 0},
                      {x, -kLane, 0},
                      {half + kPlace, -11, 0},
                      {far, 0, 0},
                      {half + kPlace, 11, 0},
                      {x, kLane, 0},
                      {-x, kLane, 0},
                      {-half - kPlace, 11, 0},
                      {-far, 0, 0},
                      {-half - kPlace, -11, 0}},
                     true}};
    return world;
  }

 private:
  void addDeck(MeshBuilder& builder, const RoughGround& rough, RandomSequence& random) const {
    const double half = params_.length_m / 2;
    builder.material("asphalt").terrain(-half, -kHalf, half, kHalf, 1, rough);
    builder.material("concrete");
    builder.box({0, 0, -1.2}, params_.length_m, 2 * kHalf + 1, 1.1);
    for (const double side : {-1.0, 1.0}) {  // footway-less edge beams, then rails with upright bars
      builder.box({0, side * (kHalf + 0.25), -0.1}, params_.length_m, 0.5, 0.25);
      const int pieces = std::max(1, static_cast<int>(params_.length_m / 20));
      for (int i = 0; i < pieces; ++i) {
        const double a = -half + params_.length_m * i / pieces, b = -half + params_.length_m * (i + 1) / pieces;
        addFence(builder, {a, side * (kHalf + 0.3), 0.15}, {b, side * (kHalf + 0.3), 0.15}, 1.1, FenceKind::kRails);
      }
    }
    builder.material("concrete");
    const int piers = std::max(1, static_cast<int>(params_.length_m / 50));
    for (int i = 1; i < piers; ++i)
      builder.box({-half + params_.length_m * i / piers, 0, -params_.clearance_m - 1}, 2, 8,
                  params_.clearance_m - 0.15);
    if (params_.lamp_spacing_m == 0) return;
    for (double x = -half + params_.lamp_spacing_m / 2; x < half; x += params_.lamp_spacing_m)
      addPole(builder, poseFromYaw(-M_PI / 2, {x, kHalf + 0.3, 0.1}), random);
  }

  /// Height of the land at a distance behind the end of the deck [m].
  double land(double behind, double y) const {
    const double shore = std::clamp((behind + 18) / 18, 0.0, 1.0), far = std::max(0.0, std::abs(y) - 30) / 40;
    const double fall = (params_.clearance_m + 1) * (1 - shore * shore * (3 - 2 * shore));
    return (behind < 0 ? -0.3 : 0) - fall + std::min(6.0, 2 * far * far);
  }

  static bool isRoad(double behind, double y) {
    return behind > 0 && behind < kBank && (std::abs(y) < kHalf || std::hypot(behind - kPlace, y) < kPlaceRadius);
  }

  void addBank(MeshBuilder& builder, double side, const RoughGround& rough, RandomSequence& random) const {
    const double end = params_.length_m / 2;
    const double x0 = side > 0 ? end : -end - kBank, x1 = side > 0 ? end + kBank : -end;
    const auto behind = [&](double x) { return side * x - end; };
    const auto ground = [&](double x, double y) {
      return land(behind(x), y) + rough(x, y) * (isRoad(behind(x), y) ? 1 : 2.2);
    };
    // Road and what is near it in cells of 1 m, the rest in cells of 5 m; each dives under the other where they meet.
    constexpr double kNear = 20;
    const auto fine = [&](double x, double y) { return ground(x, y) - (std::abs(y) > kNear ? 0.3 : 0); };
    const auto coarse = [&](double x, double y) { return ground(x, y) - (std::abs(y) < kNear ? 0.3 : 0); };
    const auto shore = [&](double x, double y) { return ground(x, y) - (behind(x) > 1 ? 0.3 : 0); };
    builder.material("asphalt").terrain(x0, -kNear - 1, x1, kNear + 1, 1, fine,
                                        [&](double x, double y) { return isRoad(behind(x), y); });
    builder.material("grass").terrain(x0, -kNear - 1, x1, kNear + 1, 1, fine,
                                      [&](double x, double y) { return !isRoad(behind(x), y); });
    builder.terrain(x0, -150, x1, -kNear + 5, 5, coarse);
    builder.terrain(x0, kNear - 5, x1, 150, 5, coarse);
    builder.material("soil");
    builder.terrain(side > 0 ? end - 18 : -end - 3, -150, side > 0 ? end + 3 : -end + 18, 150, 3, shore);
    addThings(builder, side, ground, random);
  }

  void addThings(MeshBuilder& builder, double side, const std::function<double(double, double)>& ground,
                 RandomSequence& random) const {
    const double end = params_.length_m / 2;
    const auto at = [&](double behind, double y) {
      const double x = side * (end + behind);
      return Vector3d(x, y, ground(x, y));
    };
    for (const double row : {-1.0, 1.0}) {
      addFence(builder, at(0, row * (kHalf + 0.6)), at(40, row * (kHalf + 0.6)), 0.75, FenceKind::kGuardRail);
      for (int i = 0; i < 3; ++i) {
        const double behind = 15 + 42 * i + random.uniform(-4, 4);
        addHouse(builder, poseFromYaw(row > 0 ? 0 : M_PI, at(behind, row * random.uniform(28, 34))),
                 random.uniform(9, 15), random.uniform(8, 10), 2 + random.below(2), random);
      }
      for (int i = 0; i < 8; ++i)
        addTree(builder, at(6 + 15.5 * i, row * random.uniform(41, 60)), random.uniform(6, 14), random);
      for (int i = 0; i < 4; ++i)
        addTree(builder, at(8 + 18 * i, row * random.uniform(10, 16)), random.uniform(4, 8), random);
      for (int i = 0; i < 3; ++i)
        addPole(builder, poseFromYaw(-row * M_PI / 2, at(4 + 28.0 * i, row * (kHalf + 1.4))), random);
    }
  }

  Params params_;
};

}  // namespace

SCSLAM_REGISTER(sim::WorldGenerator, sim::Bridge, "bridge",
                "long bridge over water: no ground beside the deck, structure only on the banks")

}  // namespace scslam::sim
