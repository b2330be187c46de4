// Hilly country: a winding road that closes, with constant slopes up and down, fields, trees, fences, a few houses.
//
// The road runs counter-clockwise around the origin and starts south of it, heading east (+x) and uphill. Its length
// follows from height and slope: 40 m at 8 % make about 2.8 km, 12 m about 0.8 km. Route "loop", closed, on its
// right-hand lane.
#include <algorithm>
#include <cmath>

#include "scslam/core/error.h"
#include "sim/props.h"
#include "sim/scenery.h"
#include "sim/world_generator.h"

namespace scslam::sim {
namespace {

using Eigen::Vector3d;

constexpr double kRoad = 3.5, kVerge = 9, kLane = 1.75;  // half widths, offset of the lane [m]

class Hills : public WorldGenerator {
 public:
  struct Params : ParamSetOf<Params> {
    double height_m = 40, slope = 0.08, trees_per_km = 40;
    int houses = 8;
    void describe(ParamVisitor& v) override {
      v.field("height_m", height_m, "the road climbs this far above and falls this far below the middle [m]", 2, 200);
      v.field("slope", slope, "steepest slope of the road", 0.01, 0.25);
      v.field("trees_per_km", trees_per_km, "along the road", 0, 500);
      v.field("houses", houses, "by the road", 0, 200);
    }
  };

  Hills(const Params& params, const PluginContext&) : params_(params) {
    // Radius such that the steepest place has the slope asked for.
    radius_ = 1;
    double steepest = 0;
    constexpr int kSamples = 2000;
    for (int i = 0; i < kSamples; ++i) {
      const Vector3d step = at(2 * M_PI * (i + 1) / kSamples) - at(2 * M_PI * i / kSamples);
      steepest = std::max(steepest, std::abs(step.z()) / step.head<2>().norm());
    }
    radius_ = steepest / params_.slope;
    if (radius_ < 45)
      throw usageError("hills of {} m with slopes of {} leave no room for a road (loop of {:.0f} m): higher or flatter",
                       params_.height_m, params_.slope, 2 * M_PI * radius_);
    if (radius_ > 2000)
      throw usageError("hills of {} m with slopes of {} make a loop of {:.0f} km: lower or steeper, 12 km at most",
                       params_.height_m, params_.slope, 2 * M_PI * radius_ / 1000);
  }

  World generate(std::uint64_t seed) const override {
    const RoughGround rough(seed, 0.015);
    const CounterRandom bumps(seed, RandomStream::kWorld, 5);
    const auto ground = [&](double x, double y) { return land(x, y, bumps) + rough(x, y); };
    const Line road = line(2);
    MeshBuilder builder;
    addGround(builder, road, ground);
    RandomSequence random(CounterRandom(seed, RandomStream::kWorld));
    addThings(builder, road, ground, random);
    World world;
    world.name = "hills";
    world.mesh = builder.take();
    Line lane = line(1);
    const Line left = leftOf(lane, true);
    for (std::size_t i = 0; i < lane.size(); ++i) lane[i] -= left[i] * kLane;
    lane.pop_back();
    world.routes = {{"loop", lane, true}};
    return world;
  }

 private:
  /// The road's middle at an angle about the origin; 0 is south.
  Vector3d at(double angle) const {
    constexpr double kRound = 0.97;  // of a triangle wave: 0 sine, 1 sharp
    const double r =
        radius_ * (1 + 0.10 * std::sin(2 * angle + 0.7) + 0.07 * std::sin(3 * angle) + 0.035 * std::sin(5 * angle + 2));
    const double z = params_.height_m * std::asin(kRound * std::sin(angle)) / std::asin(kRound);
    return {r * std::sin(angle), -r * std::cos(angle), z};
  }

  /// The road's middle every `step_m`, closed: the last point is the first.
  Line line(double step_m) const {
    Line fine;
    constexpr int kSamples = 4000;
    for (int i = 0; i < kSamples; ++i) fine.push_back(at(2 * M_PI * i / kSamples));
    return resampled(fine, step_m, true);
  }

  /// Land: the road's height beside the road, falling to 0 towards the origin, with hillocks away from the road.
  double land(double x, double y, const CounterRandom& random) const {
    const double angle = std::atan2(x, -y), r = std::hypot(x, y);
    const Vector3d road = at(angle);
    const double there = road.head<2>().norm(), u = std::clamp(r / there / 0.85, 0.0, 1.0);
    const double away = std::max(0.0, std::abs(r - there) - kVerge) / 40;
    const double blend = away * away / (1 + away * away);
    return road.z() * u * u * (3 - 2 * u) + blend * hillocks(x, y, random);
  }

  static double hillocks(double x, double y, const CounterRandom& random) {
    double z = 0;
    for (std::uint32_t k = 0; k < 6; ++k) {
      const auto word = random.block(k);
      const double heading = 2 * M_PI * static_cast<double>(uniformOf(word[0]));
      const double wave = 50 + 60 * static_cast<double>(uniformOf(word[1]));
      const double phase = 2 * M_PI * static_cast<double>(uniformOf(word[2]));
      z += 1.2 * std::sin(2 * M_PI / wave * (x * std::cos(heading) + y * std::sin(heading)) + phase);
    }
    return z;
  }

  void addGround(MeshBuilder& builder, const Line& road, const std::function<double(double, double)>& ground) const {
    const auto flat = std::vector<double>(8, 0.0);
    builder.material("asphalt");
    addRibbon(builder, road, steps(-kRoad, kRoad, 7), flat, ground, true);
    builder.material("grass");
    for (const double side : {-1.0, 1.0}) {
      auto offsets = steps(kRoad, kVerge, 5), lifts = std::vector<double>(5, 0.03);
      lifts.insert(lifts.begin(), 0.0);
      offsets.push_back(kVerge + 1), lifts.push_back(-0.4);  // into the land
      if (side < 0) {
        std::reverse(offsets.begin(), offsets.end()), std::reverse(lifts.begin(), lifts.end());
        for (double& offset : offsets) offset = -offset;
      }
      addRibbon(builder, road, offsets, lifts, ground, true);
    }
    // Coarse cells reach in under the verge, where they lie deeper.
    const double reach = 1.25 * radius_ + 70;
    const auto fromRoad = [&](double x, double y) {
      const Vector3d p(x, y, 0);
      const double radial = std::abs(p.norm() - at(std::atan2(x, -y)).head<2>().norm());
      return radial > 3 * kVerge ? radial : distance(road, p);
    };
    builder.terrain(
        -reach, -reach, reach, reach, 5,
        [&](double x, double y) { return ground(x, y) - (fromRoad(x, y) < kVerge - 0.5 ? 0.6 : 0); },
        [&](double x, double y) { return fromRoad(x, y) > kVerge - 4; });
  }

  /// From the road's middle, in plan.
  static double distance(const Line& road, const Vector3d& p) {
    double nearest = 1e9;
    for (const Vector3d& q : road) nearest = std::min(nearest, (q - p).head<2>().squaredNorm());
    return std::sqrt(nearest);
  }

  void addThings(MeshBuilder& builder, const Line& road, const std::function<double(double, double)>& ground,
                 RandomSequence& random) const {
    const Line left = leftOf(road, true);
    const auto beside = [&](double s, double offset) {
      const auto i = static_cast<std::size_t>(std::clamp(s, 0.0, 1.0) * static_cast<double>(road.size() - 1));
      Vector3d p = road[i] + left[i] * offset;
      p.z() = ground(p.x(), p.y());
      return p;
    };
    const auto side = [&] { return random.below(2) == 0 ? -1.0 : 1.0; };
    const double length = lengthOf(road);
    for (int i = 0; i < params_.houses; ++i) {
      const double s = (i + random.uniform(0.2, 0.8)) / params_.houses, which = side();
      const Vector3d p = beside(s, which * random.uniform(20, 30)), towards = beside(s, 0) - p;
      const double turn = std::atan2(towards.y(), towards.x()) + M_PI / 2;
      const double l = random.uniform(9, 14), w = random.uniform(7, 9);
      const int storeys = 1 + random.below(2);
      if (distance(road, p) > 18) addHouse(builder, poseFromYaw(turn, p), l, w, storeys, random);
    }
    const int trees = static_cast<int>(params_.trees_per_km * length / 1000);
    for (int i = 0; i < trees; ++i) {
      const double height = random.uniform(4, 13), out = 6 + 0.37 * height + 32 * std::pow(random.uniform(), 2);
      const double s = (i + random.uniform()) / trees;
      const Vector3d p = beside(s, side() * out);
      if (distance(road, p) > 5 + 0.37 * height) addTree(builder, p, height, random);
    }
    for (double at = 15; at + 60 < length; at += 130) {  // stretches of meadow fence, then a pole
      const double which = side(), out = random.uniform(5.5, 8);
      for (int k = 0; k < 6; ++k)
        addFence(builder, beside((at + 10 * k) / length, which * out),
                 beside((at + 10 * (k + 1)) / length, which * out), 1.2, FenceKind::kRails);
      addPole(builder, poseFromYaw(0, beside((at + 95) / length, which * 6.5)), random);
    }
  }

  Params params_;
  double radius_ = 0;
};

}  // namespace

SCSLAM_REGISTER(sim::WorldGenerator, sim::Hills, "hills",
                "winding country road over hills that closes: slopes, trees, fences, few houses")

}  // namespace scslam::sim
