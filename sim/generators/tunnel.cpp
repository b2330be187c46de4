// A road tunnel of round section that bends one way and back, with 105 m of open road before and behind it.
//
// The road begins at the origin and heads along +x. Round section: a circle of radius_m whose middle is
// kMiddle above the road. Route "through": in the middle of the right-hand lane from 30 m on; turn-about is not
// provided for.
#include <algorithm>
#include <cmath>

#include "scslam/core/error.h"
#include "sim/props.h"
#include "sim/scenery.h"
#include "sim/world_generator.h"

namespace scslam::sim {
namespace {

using Eigen::Vector3d;

constexpr double kMiddle = 1.4, kOpen = 105, kStep = 1.5, kWalk = 0.8;  // [m]

class Tunnel : public WorldGenerator {
 public:
  struct Params : ParamSetOf<Params> {
    double length_m = 600, radius_m = 5.5, bend_radius_m = 300;
    bool pipes = false, lamps = false;
    void describe(ParamVisitor& v) override {
      v.field("length_m", length_m, "of the tunnel [m]", 20, 5000);
      v.field("radius_m", radius_m, "of its round section [m]", 4.5, 20);
      v.field("bend_radius_m", bend_radius_m, "its first half bends left, its second right; 0: straight [m]", 0,
              100000);
      v.field("pipes", pipes, "two pipes along the left wall, on brackets");
      v.field("lamps", lamps, "lamps at the crown every 12 m, niches' signs every 50 m");
    }
  };

  Tunnel(const Params& params, const PluginContext&) : params_(params) {
    const double r = params_.bend_radius_m;
    if (r != 0 && (r < 30 || params_.length_m / 2 > 2.5 * r))
      throw usageError("a tunnel of {} m cannot bend with a radius of {} m: at least {} m (or 0, straight)",
                       params_.length_m, r, std::max(30.0, std::ceil(params_.length_m / 5)));
  }

  World generate(std::uint64_t seed) const override {
    const Line line = centreLine();
    const auto first = static_cast<std::size_t>(kOpen / kStep);
    const std::size_t last = line.size() - 1 - first;
    const Line inside(line.begin() + static_cast<std::ptrdiff_t>(first),
                      line.begin() + static_cast<std::ptrdiff_t>(last) + 1);
    const RoughGround rough(seed, 0.01);
    const auto ground = [&](double x, double y) { return rough(x, y); };
    MeshBuilder builder;
    const double half = halfWidth();
    builder.material("asphalt");
    addRibbon(builder, line, steps(-half, half, 9), std::vector<double>(10, 0.0), ground);
    addLining(builder, inside);
    if (params_.pipes) addPipes(builder, inside);
    if (params_.lamps) addLamps(builder, inside);
    RandomSequence random(CounterRandom(seed, RandomStream::kWorld));
    addOutside(builder, Line(line.begin(), line.begin() + static_cast<std::ptrdiff_t>(first) + 1), true, rough, random);
    addOutside(builder, Line(line.begin() + static_cast<std::ptrdiff_t>(last), line.end()), false, rough, random);
    World world;
    world.name = "tunnel";
    world.mesh = builder.take();
    world.routes = {{"through", lane(line), false}};
    return world;
  }

 private:
  double halfWidth() const { return std::sqrt(params_.radius_m * params_.radius_m - kMiddle * kMiddle); }

  Line centreLine() const {
    const double total = params_.length_m + 2 * kOpen;
    const int n = static_cast<int>(std::lround(total / kStep));
    Line line = {Vector3d::Zero()};
    double heading = 0;
    for (int i = 0; i < n; ++i) {
      const double s = (i + 0.5) * kStep - kOpen;
      const double turn = params_.bend_radius_m == 0 || s < 0 || s > params_.length_m ? 0
                          : s < params_.length_m / 2                                  ? kStep / params_.bend_radius_m
                                                                                      : -kStep / params_.bend_radius_m;
      const double middle = heading + turn / 2;
      line.push_back(line.back() + kStep * Vector3d(std::cos(middle), std::sin(middle), 0));
      heading += turn;
    }
    return line;
  }

  Line lane(const Line& line) const {
    const Line left = leftOf(line);
    Line result;
    for (std::size_t i = 20; i + 20 < line.size(); ++i) result.push_back(line[i] - left[i] * halfWidth() * 0.35);
    return result;
  }

  /// Lining and raised walkways.
  void addLining(MeshBuilder& builder, const Line& line) const {
    const Line left = leftOf(line);
    const double r = params_.radius_m, low = -std::asin(kMiddle / r);
    constexpr int kSides = 40;
    builder.material("tunnel_lining");
    builder.patch(static_cast<int>(line.size()) - 1, kSides, [&](int row, int column) {
      const auto i = static_cast<std::size_t>(row);
      const double angle = low + (M_PI - 2 * low) * (kSides - column) / kSides;  // from the left over the crown
      return Vector3d(line[i] - left[i] * r * std::cos(angle) + Vector3d(0, 0, kMiddle + r * std::sin(angle)));
    });
    builder.material("kerb");
    const double w = halfWidth();
    const auto flat = [](double, double) { return 0.0; };
    addRibbon(builder, line, {w - kWalk, w - kWalk + 0.01, w + 0.1}, {-0.1, 0.2, 0.2}, flat);
    addRibbon(builder, line, {-w - 0.1, -w + kWalk - 0.01, -w + kWalk}, {0.2, 0.2, -0.1}, flat);
  }

  void addPipes(MeshBuilder& builder, const Line& line) const {
    const Line left = leftOf(line);
    const double r = params_.radius_m - 0.3;
    for (const double angle : {25.0, 33.0}) {
      const double out = r * std::cos(angle * M_PI / 180), up = kMiddle + r * std::sin(angle * M_PI / 180);
      const auto at = [&](std::size_t i) { return Vector3d(line[i] + left[i] * out + Vector3d(0, 0, up)); };
      builder.newInstance().material("metal");
      for (std::size_t i = 0; i + 2 < line.size(); i += 2) builder.cylinder(at(i), at(i + 2), 0.12, 8);
      for (std::size_t i = 1; i + 1 < line.size(); i += 4)
        builder.cylinder(at(i), at(i) + left[i] * 0.3 + Vector3d(0, 0, 0.1), 0.03, 4);
    }
    builder.noInstance();
  }

  void addLamps(MeshBuilder& builder, const Line& line) const {
    const Line left = leftOf(line);
    const auto pose = [&](std::size_t i, double offset, double z) {
      return poseFromYaw(std::atan2(-left[i].x(), left[i].y()), line[i] + left[i] * offset + Vector3d(0, 0, z));
    };
    for (std::size_t i = 4; i + 4 < line.size(); i += 8) {
      builder.newInstance().material("metal");
      builder.box(pose(i, 0, kMiddle + params_.radius_m - 0.35), 1.2, 0.3, 0.12);
    }
    const double wall = std::sqrt(std::pow(params_.radius_m, 2) - std::pow(2.2 - kMiddle, 2)) - 0.12;
    for (std::size_t i = 16; i + 4 < line.size(); i += 33) {
      builder.newInstance().material("sign");
      builder.box(pose(i, wall, 1.9), 0.6, 0.04, 0.6);
    }
    builder.noInstance();
  }

  /// The open road before (or behind) the tunnel: portal, verges, trees, guard rails.
  void addOutside(MeshBuilder& builder, const Line& line, bool before, const RoughGround& rough,
                  RandomSequence& random) const {
    const Line left = leftOf(line);
    const auto mouth = before ? line.size() - 1 : 0;
    const double half = halfWidth();
    const auto ground = [&](double x, double y) { return 2 * rough(x, y); };
    builder.material("grass");
    auto offsets = steps(half, half + 40, 20), lifts = std::vector<double>(21, 0.02);
    offsets.insert(offsets.begin(), half - 0.5), lifts.insert(lifts.begin(), -0.25);  // in under the road
    addRibbon(builder, line, offsets, lifts, ground);
    std::reverse(offsets.begin(), offsets.end()), std::reverse(lifts.begin(), lifts.end());
    for (double& offset : offsets) offset = -offset;
    addRibbon(builder, line, offsets, lifts, ground);
    addPortal(builder, line[mouth], left[mouth], before);
    for (const double side : {-1.0, 1.0}) {
      const std::size_t a = before ? 0 : 2, b = before ? line.size() - 3 : line.size() - 1;
      const auto at = [&](std::size_t i) { return Vector3d(line[i] + left[i] * side * (half + 0.4)); };
      if (side > 0)
        addFence(builder, at(b), at(a), 0.75, FenceKind::kGuardRail);
      else
        addFence(builder, at(a), at(b), 0.75, FenceKind::kGuardRail);
      for (std::size_t i = 3; i + 3 < line.size(); i += 9) {
        const double out = half + random.uniform(5, 30);
        addTree(builder, line[i] + left[i] * side * out, random.uniform(6, 13), random);
      }
    }
  }

  /// The wall around the mouth, 14 m high and 80 m wide: between the arch and a rectangle.
  void addPortal(MeshBuilder& builder, const Vector3d& at, const Vector3d& left, bool before) const {
    constexpr int kSides = 40;
    const double r = params_.radius_m, low = -std::asin(kMiddle / r), wide = halfWidth() + 40, high = 2 * r + 4;
    builder.material("concrete");
    builder.patch(1, kSides, [&](int row, int column) {
      const int k = before ? column : kSides - column;
      const double angle = low + (M_PI - 2 * low) * k / kSides, c = std::cos(angle), s = std::sin(angle);
      double u = r * c, z = kMiddle + r * s;
      if (row == 1) {  // outwards from the arch's middle until a side or the top of the rectangle
        const double reach =
            std::min(std::abs(c) > 1e-9 ? wide / std::abs(c) : 1e9, s > 1e-9 ? (high - kMiddle) / s : 1e9);
        u = reach * c, z = s > 0 ? kMiddle + reach * s : kMiddle * (1 - std::min(angle, M_PI - angle) / low);
      }
      return Vector3d(at - left * u + Vector3d(0, 0, z));
    });
  }

  Params params_;
};

}  // namespace

SCSLAM_REGISTER(sim::WorldGenerator, sim::Tunnel, "tunnel",
                "bent road tunnel of round section, pipes and lamps optional, open road at both ends")

}  // namespace scslam::sim
