// A roundabout with four arms, kerbs, houses between the arms.
//
// Its middle is the origin, the arms run along x and y; right-hand traffic, counter-clockwise. Routes: "turns" from the
// end of the western arm heading east (+x), `turns` times around and out by the eastern arm; "circle", closed, only the
// circle.
#include <algorithm>
#include <cmath>

#include "sim/props.h"
#include "sim/scenery.h"
#include "sim/world_generator.h"

namespace scslam::sim {
namespace {

using Eigen::Vector3d;

constexpr double kArm = 5.5, kLane = 2.75, kKerb = 0.12, kRing = 6;  // half width, lane, kerb height, half ring [m]

class Roundabout : public WorldGenerator {
 public:
  struct Params : ParamSetOf<Params> {
    double radius_m = 20, arm_m = 90;
    int turns = 5;
    void describe(ParamVisitor& v) override {
      v.field("radius_m", radius_m, "of the circle that is driven, in the middle of a road of 12 m [m]", 14, 100);
      v.field("arm_m", arm_m, "length of the arms beyond the circle [m]", 25, 400);
      v.field("turns", turns, "of the route \"turns\"", 1, 1000);
    }
  };

  Roundabout(const Params& params, const PluginContext&) : params_(params) {}

  World generate(std::uint64_t seed) const override {
    const RoughGround rough(seed, 0.012);
    RandomSequence random(CounterRandom(seed, RandomStream::kWorld));
    MeshBuilder builder;
    addGround(builder, rough);
    addIsland(builder, rough, random);
    for (int quadrant = 0; quadrant < 4; ++quadrant) addCorner(builder, quadrant, rough, random);
    World world;
    world.name = "roundabout";
    world.mesh = builder.take();
    Line circle = arc(Vector3d::Zero(), params_.radius_m, 0, 360, 1);
    circle.pop_back();
    world.routes = {{"turns", turns(), false}, {"circle", circle, true}};
    return world;
  }

 private:
  double outer() const { return params_.radius_m + kRing; }
  double inner() const { return params_.radius_m - kRing; }
  double reach() const { return outer() + params_.arm_m; }

  Line turns() const {
    const double off = std::asin(8.5 / params_.radius_m) * 180 / M_PI;
    const double enter = 180 + off, leave = 360 - off, end = reach() - 15;
    Line line = {{-end, -kLane, 0}, {-outer() - 8, -kLane, 0}};
    const Line around = arc(Vector3d::Zero(), params_.radius_m, enter, leave + 360.0 * params_.turns, 1);
    line.insert(line.end(), around.begin(), around.end());
    line.emplace_back(outer() + 8, -kLane, 0);
    line.emplace_back(end, -kLane, 0);
    return line;
  }

  /// Edge of the road between two arms, turned by `quadrant` quarters: from the end of one arm to that of the next.
  Line edge(int quadrant) const {
    const double start = std::asin(kArm / outer()) * 180 / M_PI + 9;
    Line line = {{reach(), kArm, 0}, {outer() + 9, kArm, 0}, {outer() + 3.5, kArm + 0.9, 0}};
    const Line middle = arc(Vector3d::Zero(), outer(), start, 90 - start, 5);
    line.insert(line.end(), middle.begin(), middle.end());
    line.emplace_back(kArm + 0.9, outer() + 3.5, 0);
    line.emplace_back(kArm, outer() + 9, 0);
    line.emplace_back(kArm, reach(), 0);
    const Pose turn = poseFromYaw(quadrant * M_PI / 2, Vector3d::Zero());
    for (Vector3d& p : line) p = turn * p;
    return line;
  }

  /// How far outside the road, about [m]; negative on it. The island is road here.
  double outside(double x, double y) const {
    return std::min({std::hypot(x, y) - outer(), std::abs(x) - kArm, std::abs(y) - kArm});
  }

  void addGround(MeshBuilder& builder, const RoughGround& rough) const {
    const double r = std::ceil(reach());
    builder.material("asphalt").terrain(-r - 2, -r - 2, r + 2, r + 2, 1, rough, [&](double x, double y) {
      return outside(x, y) < 2.5 && std::hypot(x, y) > inner() - 2;
    });
    builder.material("grass").terrain(
        -r - 40, -r - 40, r + 40, r + 40, 2,
        [&](double x, double y) { return 2 * rough(x, y) + kKerb - 0.1 * std::clamp(5.2 - outside(x, y), 0.0, 1.0); },
        [&](double x, double y) { return std::max(std::abs(x), std::abs(y)) > r || outside(x, y) > 3; });
  }

  void addIsland(MeshBuilder& builder, const RoughGround& rough, RandomSequence& random) const {
    const double r = inner();
    const Line rim = resampled(arc(Vector3d::Zero(), r, 0, 360, 3), 1);
    builder.material("kerb");
    addRibbon(builder, rim, {0, 0.3, 0.9}, {kKerb, kKerb, -0.2}, rough, true);
    addRibbon(builder, rim, {-0.01, 0}, {-0.15, kKerb}, rough, true);
    builder.material("grass");
    const int rings = static_cast<int>(r - 0.3);
    builder.patch(48, rings, [&](int i, int j) {
      const double angle = -2 * M_PI * i / 48, s = (r - 0.3) * (0.02 + 0.98 * j / rings);
      const double x = s * std::cos(angle), y = s * std::sin(angle), hump = 1 - std::pow(s / r, 2);
      return Vector3d(x, y, rough(x, y) + kKerb + 0.8 * hump);
    });
    addTree(builder, {0.5, -0.3, 0.8}, 9, random);
    for (int k = 0; k < 5; ++k) {
      const double angle = random.uniform(0, 2 * M_PI), out = random.uniform(0.4, 0.75) * r;
      addBush(builder, {out * std::cos(angle), out * std::sin(angle), 0.4}, random.uniform(0.6, 1.3), random);
    }
    for (int k = 0; k < 4; ++k)
      addSign(builder,
              poseFromYaw(k * M_PI / 2, {(r - 1) * std::cos(k * M_PI / 2), (r - 1) * std::sin(k * M_PI / 2), kKerb}),
              random);
  }

  /// Kerb, pavement, houses and furniture between two arms.
  void addCorner(MeshBuilder& builder, int quadrant, const RoughGround& rough, RandomSequence& random) const {
    const Line line = resampled(edge(quadrant), 1);
    builder.material("kerb");
    addRibbon(builder, line, {-0.3, -0.01, 0}, {kKerb, kKerb, -0.15}, rough);
    builder.material("paving");
    addRibbon(builder, line, {-5.2, -4.2, -2.9, -1.6, -0.3}, {-0.3, kKerb, kKerb, kKerb, kKerb}, rough);
    const Pose turn = poseFromYaw(quadrant * M_PI / 2, Vector3d::Zero());
    const auto place = [&](double x, double y, double yaw) {
      return Pose(turn * poseFromYaw(yaw, Vector3d(x, y, kKerb)));
    };
    const double first = outer() + 6;
    for (double s = first; s + 14 < reach(); s += random.uniform(17, 22)) {
      addHouse(builder, place(s + 7, kArm + 10 + random.uniform(0, 3), 0), random.uniform(10, 14),
               random.uniform(8, 10), 2 + random.below(2), random);
      if (s > first + 1)
        addHouse(builder, place(kArm + 10 + random.uniform(0, 3), s + 7, -M_PI / 2), random.uniform(10, 14),
                 random.uniform(8, 10), 2 + random.below(2), random);
    }
    for (double s = first; s < reach() - 4; s += 24) {
      addPole(builder, place(s, kArm + 0.7, -M_PI / 2), random);
      addTree(builder, place(kArm + 2.6, s + 6, 0).translation(), random.uniform(5, 7), random);
    }
    const double diagonal = (outer() + 2) * std::sqrt(0.5);
    addPole(builder, place(diagonal, diagonal, -3 * M_PI / 4), random);
    addBench(builder, place(diagonal + 1.2, diagonal - 3, -3 * M_PI / 4), random);
    addBin(builder, place(diagonal - 3, diagonal + 1.2, 0), random);
    addSign(builder, place(outer() + 8, kArm + 0.8, 0), random);
    addTree(builder, place(diagonal + 9, diagonal + 9, 0).translation(), random.uniform(8, 12), random);
  }

  Params params_;
};

}  // namespace

SCSLAM_REGISTER(sim::WorldGenerator, sim::Roundabout, "roundabout",
                "roundabout with four arms, kerbs and houses: a drive that turns and turns")

}  // namespace scslam::sim
