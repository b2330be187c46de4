// Streets in a grid with what streets have: houses with gaps between them, pavements with kerbs, parked cars, trees,
// lamp posts, signs; cars, cyclists and people on the move.
#include <algorithm>
#include <array>
#include <cmath>

#include "sim/facade.h"
#include "sim/props.h"
#include "sim/world_generator.h"

namespace scslam::sim {

namespace {

using Eigen::Vector3d;

constexpr double kKerb = 0.12;  ///< height of pavements and blocks above the road [m]

class Town final : public WorldGenerator {
 public:
  struct Params : ParamSetOf<Params> {
    int blocks_x = 2, blocks_y = 2;
    double block_x_m = 60, block_y_m = 48, road_m = 10, pavement_m = 3;
    double hills_m = 0.6, rough_m = 0.015;
    double house_height_m = 11, gap_share = 0.15;
    double parked_share = 0.45, tree_share = 0.5, leaf_share = 1;
    int cars = 4, people = 8, cyclists = 2;
    int parked_seed = 0;
    double parked_replaced = 0;
    void describe(ParamVisitor& v) override {
      v.field("blocks_x", blocks_x, "blocks along x", 1, 30);
      v.field("blocks_y", blocks_y, "blocks along y", 1, 30);
      v.field("block_x_m", block_x_m, "size of a block along x [m]", 24, 500);
      v.field("block_y_m", block_y_m, "size of a block along y [m]", 24, 500);
      v.field("road_m", road_m, "kerb to kerb [m]", 5, 60);
      v.field("pavement_m", pavement_m, "width of a pavement [m]", 1.5, 20);
      v.field("hills_m", hills_m, "the ground swells by so much [m]", 0, 20);
      v.field("rough_m", rough_m, "roughness of the ground, one sigma over about 2 m [m]", 0, 0.2);
      v.field("house_height_m", house_height_m, "mean height of houses [m]", 3, 60);
      v.field("gap_share", gap_share, "share of plots that are gardens", 0, 1);
      v.field("parked_share", parked_share, "share of parking places taken", 0, 1);
      v.field("parked_seed", parked_seed, "another one re-parks parked_replaced of the cars");
      v.field("parked_replaced", parked_replaced, "share of the parking places that parked_seed decides anew", 0, 1);
      v.field("tree_share", tree_share, "share of places for trees taken", 0, 1);
      v.field("leaf_share", leaf_share, "leaves on the trees: 1 summer, 0 bare", 0, 1);
      v.field("cars", cars, "moving cars", 0, 500);
      v.field("people", people, "people walking", 0, 500);
      v.field("cyclists", cyclists, "people cycling", 0, 500);
    }
  };

  Town(const Params& params, const PluginContext&) : p_(params) {}

  World generate(std::uint64_t seed) const override {
    World world;
    world.name = "town";
    MeshBuilder b;
    const CounterRandom random(seed, RandomStream::kWorld);
    layGround(b);
    std::uint32_t what = 0;
    for (int i = -1; i <= p_.blocks_x; ++i)
      for (int j = -1; j <= p_.blocks_y; ++j) {
        RandomSequence block(random, ++what);
        buildBlock(b, i, j, block);
      }
    for (const Street& street : streets()) {
      RandomSequence along(random, ++what);
      furnish(b, street, along, random, ++what);
    }
    for (int i = 0; i <= p_.blocks_x; ++i)
      for (int j = 0; j <= p_.blocks_y; ++j) {
        RandomSequence corner(random, ++what);
        furnishCorner(b, i, j, corner);
      }
    world.mesh = b.take();
    RandomSequence moving(CounterRandom(seed, RandomStream::kActors));
    addActors(world, moving);
    addRoutes(world);
    return world;
  }

 private:
  /// A street from one junction to the next.
  struct Street {
    Vector3d from, to;
  };

  double pitchX() const { return p_.block_x_m + p_.road_m + 2 * p_.pavement_m; }
  double pitchY() const { return p_.block_y_m + p_.road_m + 2 * p_.pavement_m; }
  Vector3d junction(double i, double j) const { return {i * pitchX(), j * pitchY(), 0}; }

  double road(double x, double y) const {
    const double rough = std::sin(1.7 * x + 0.3) * std::sin(1.3 * y) + 0.7 * std::sin(2.9 * x + 2.1 * y) +
                         0.5 * std::sin(0.9 * x - 2.3 * y + 1.1);
    return p_.hills_m * std::sin(x / 90) * std::cos(y / 70) + p_.rough_m * 1.35 * rough;
  }
  double pavement(double x, double y) const { return road(x, y) + kKerb; }
  Vector3d onPavement(const Vector3d& p) const { return {p.x(), p.y(), pavement(p.x(), p.y())}; }
  Vector3d onRoad(const Vector3d& p) const { return {p.x(), p.y(), road(p.x(), p.y())}; }

  /// Along one axis: what lies from where to where.
  enum class Strip { kRoad, kPavement, kBlock };
  struct Interval {
    double from, to;
    Strip strip;
  };
  std::vector<Interval> intervals(int blocks, double block, double pitch) const {
    std::vector<Interval> all;
    const double half = p_.road_m / 2, edge = half + p_.pavement_m;
    all.push_back({-edge - 14, -edge, Strip::kBlock});
    for (int i = 0; i <= blocks; ++i) {
      const double c = i * pitch;
      all.push_back({c - edge, c - half, Strip::kPavement});
      all.push_back({c - half, c + half, Strip::kRoad});
      all.push_back({c + half, c + edge, Strip::kPavement});
      all.push_back({c + edge, c + edge + (i < blocks ? block : 14), Strip::kBlock});
    }
    return all;
  }

  void layGround(MeshBuilder& b) const {
    const auto xs = intervals(p_.blocks_x, p_.block_x_m, pitchX()), ys = intervals(p_.blocks_y, p_.block_y_m, pitchY());
    const auto kind = [](const Interval& x, const Interval& y) {
      if (x.strip == Strip::kRoad || y.strip == Strip::kRoad) return Strip::kRoad;
      return x.strip == Strip::kPavement || y.strip == Strip::kPavement ? Strip::kPavement : Strip::kBlock;
    };
    const auto low = [this](double x, double y) { return road(x, y); };
    const auto high = [this](double x, double y) { return pavement(x, y); };
    for (std::size_t i = 0; i < xs.size(); ++i)
      for (std::size_t j = 0; j < ys.size(); ++j) {
        const Strip strip = kind(xs[i], ys[j]);
        const bool is_road = strip == Strip::kRoad;
        b.material(is_road ? "asphalt" : strip == Strip::kPavement ? "paving" : "grass");
        // Cells of one size share their corners with their neighbours: no cracks.
        b.terrain(xs[i].from, ys[j].from, xs[i].to, ys[j].to, 1,
                  is_road ? std::function<double(double, double)>(low) : high);
        if (is_road) continue;
        b.material("kerb");
        if (i + 1 < xs.size() && kind(xs[i + 1], ys[j]) == Strip::kRoad)
          kerb(b, xs[i].to, ys[j].to, xs[i].to, ys[j].from);
        if (i > 0 && kind(xs[i - 1], ys[j]) == Strip::kRoad) kerb(b, xs[i].from, ys[j].from, xs[i].from, ys[j].to);
        if (j + 1 < ys.size() && kind(xs[i], ys[j + 1]) == Strip::kRoad)
          kerb(b, xs[i].from, ys[j].to, xs[i].to, ys[j].to);
        if (j > 0 && kind(xs[i], ys[j - 1]) == Strip::kRoad) kerb(b, xs[i].to, ys[j].from, xs[i].from, ys[j].from);
      }
  }

  void kerb(MeshBuilder& b, double x0, double y0, double x1, double y1) const {
    const int n = std::max(1, static_cast<int>(std::lround(std::hypot(x1 - x0, y1 - y0))));
    for (int k = 0; k < n; ++k) {
      const Vector3d p(x0 + (x1 - x0) * k / n, y0 + (y1 - y0) * k / n, 0);
      const Vector3d q(x0 + (x1 - x0) * (k + 1) / n, y0 + (y1 - y0) * (k + 1) / n, 0);
      b.quad(onRoad(q), onRoad(p), onPavement(p), onPavement(q));
    }
  }

  /// Houses along the four sides of block (i, j); a block outside the grid has only the sides that face a street.
  void buildBlock(MeshBuilder& b, int i, int j, RandomSequence& random) const {
    const double edge = p_.road_m / 2 + p_.pavement_m;
    const bool outside_x = i < 0 || i >= p_.blocks_x, outside_y = j < 0 || j >= p_.blocks_y;
    if (outside_x && outside_y) return;
    const double x0 = i < 0 ? -edge - 14 : junction(i, 0).x() + edge;
    const double x1 = i < 0 ? -edge : outside_x ? x0 + 14 : x0 + p_.block_x_m;
    const double y0 = j < 0 ? -edge - 14 : junction(0, j).y() + edge;
    const double y1 = j < 0 ? -edge : outside_y ? y0 + 14 : y0 + p_.block_y_m;
    const double depth = outside_x || outside_y ? 10 : std::min(10.0, 0.3 * std::min(p_.block_x_m, p_.block_y_m));
    if (!outside_x && j >= 0) buildRow(b, {x0, y0, 0}, {x1, y0, 0}, depth, random);
    if (!outside_x && j < p_.blocks_y) buildRow(b, {x1, y1, 0}, {x0, y1, 0}, depth, random);
    const double lo = outside_x ? y0 : y0 + depth, hi = outside_x ? y1 : y1 - depth;
    if (!outside_y && i < p_.blocks_x) buildRow(b, {x1, lo, 0}, {x1, hi, 0}, depth, random);
    if (!outside_y && i >= 0) buildRow(b, {x0, hi, 0}, {x0, lo, 0}, depth, random);
    if (!outside_x && !outside_y) plantCourt(b, {(x0 + x1) / 2, (y0 + y1) / 2, 0}, random);
  }

  /// Plots side by side from a to b; their fronts face right of the way.
  void buildRow(MeshBuilder& b, const Vector3d& from, const Vector3d& to, double depth, RandomSequence& random) const {
    const Vector3d right = (to - from).normalized();
    const double length = (to - from).norm();
    for (double x = 0; x < length - 5;) {
      const double width = std::min(random.uniform(9, 18), length - x);
      const Vector3d start = from + x * right;
      if (random.uniform() < p_.gap_share) {
        plantGarden(b, start, right, width, random);
      } else {
        const double setback = random.uniform() < 0.4 ? random.uniform(0.3, 1.8) : 0;
        FrontPlace place{start, right, width, p_.house_height_m * random.uniform(0.6, 1.5)};
        place.corner = onPavement(start - setback * place.outward()) - Vector3d(0, 0, 0.3);
        static const std::array<std::string, 4> kWalls = {"plaster", "brick", "concrete", "plaster"};
        FrontStyle style;
        style.wall = kWalls[static_cast<std::size_t>(random.below(4))];
        style.storey_m = random.uniform(2.8, 3.4), style.bay_m = random.uniform(2.4, 3.6);
        style.balcony_share = random.uniform() < 0.4 ? 0.4 : 0.05;
        addHouse(b, place, depth - setback, style, random);
      }
      x += width;
    }
  }

  void plantGarden(MeshBuilder& b, const Vector3d& start, const Vector3d& right, double width,
                   RandomSequence& random) const {
    const Vector3d in = -right.cross(Vector3d::UnitZ());
    addFence(b, onPavement(start), onPavement(start + width * right), 1.3);
    for (double x = 1.5; x < width - 1; x += random.uniform(2, 4))
      addBush(b, onPavement(start + x * right + random.uniform(1, 3) * in), random.uniform(0.8, 2), random,
              p_.leaf_share);
    addTree(b, onPavement(start + width / 2 * right + 5 * in), random.uniform(6, 10), random, p_.leaf_share);
  }

  void plantCourt(MeshBuilder& b, const Vector3d& centre, RandomSequence& random) const {
    for (int k = 0; k < 3; ++k)
      addTree(b, onPavement(centre + Vector3d(random.uniform(-8, 8), random.uniform(-4, 4), 0)), random.uniform(7, 12),
              random, p_.leaf_share);
  }

  std::vector<Street> streets() const {
    std::vector<Street> all;
    for (int i = 0; i <= p_.blocks_x; ++i)
      for (int j = 0; j <= p_.blocks_y; ++j) {
        if (i < p_.blocks_x) all.push_back({junction(i, j), junction(i + 1, j)});
        if (j < p_.blocks_y) all.push_back({junction(i, j), junction(i, j + 1)});
      }
    return all;
  }

  /// Parked cars, trees, lamps and the rest along both sides.
  void furnish(MeshBuilder& b, const Street& street, RandomSequence& random, const CounterRandom& source,
               std::uint32_t what) const {
    const Vector3d ahead = (street.to - street.from).normalized(), left(-ahead.y(), ahead.x(), 0);
    const double length = (street.to - street.from).norm(), clear = p_.road_m / 2 + p_.pavement_m + 5;
    RandomSequence parking(source, what);
    RandomSequence reparking(CounterRandom(static_cast<std::uint64_t>(p_.parked_seed), RandomStream::kWorld, 1), what);
    for (const double side : {-1.0, 1.0}) {
      const double heading = std::atan2(ahead.y(), ahead.x()) + (side > 0 ? M_PI : 0);
      const auto at = [&](double s, double out) { return Vector3d(street.from + s * ahead + side * out * left); };
      for (double s = clear; s < length - clear; s += 6.2) {
        const bool anew = parking.uniform() < p_.parked_replaced;
        RandomSequence& who = anew ? reparking : parking;
        if (who.uniform() < p_.parked_share)
          addCar(
              b,
              poseFromYaw(heading + who.normal() * 0.02, onRoad(at(s + who.uniform(-0.4, 0.4), p_.road_m / 2 - 1.15))),
              who);
      }
      for (double s = clear + 2; s < length - clear; s += random.uniform(8, 12))
        if (random.uniform() < p_.tree_share)
          addTree(b, onPavement(at(s, p_.road_m / 2 + 0.8)), random.uniform(5, 9), random, p_.leaf_share);
      for (double s = clear + random.uniform(0, 8); s < length - clear; s += 24)
        addPole(b, poseFromYaw(heading + M_PI / 2, onPavement(at(s, p_.road_m / 2 + 0.5))), random);
      for (double s = clear; s < length - clear; s += random.uniform(9, 22)) {
        const Pose T = poseFromYaw(heading + M_PI / 2, onPavement(at(s, p_.road_m / 2 + p_.pavement_m - 0.7)));
        switch (random.below(4)) {
          case 0:
            addBin(b, T, random);
            break;
          case 1:
            addBench(b, T, random);
            break;
          case 2:
            addBicycle(b, T, random);
            break;
          default:
            addPerson(b, T, random);
        }
      }
    }
  }

  void furnishCorner(MeshBuilder& b, int i, int j, RandomSequence& random) const {
    const double out = p_.road_m / 2 + 1.2;
    for (const auto& [sx, sy, yaw] :
         {std::array{1.0, 1.0, 0.0}, {-1.0, 1.0, 90.0}, {-1.0, -1.0, 180.0}, {1.0, -1.0, 270.0}}) {
      const Vector3d at = onPavement(junction(i, j) + Vector3d(sx * out, sy * out, 0));
      const Pose T = poseFromYaw(yaw * M_PI / 180, at);
      if (random.uniform() < 0.5)
        addTrafficLight(b, T, random);
      else
        addSign(b, T, random);
    }
  }

  /// Closed way around block (i, j), clockwise as traffic on the right goes, `out` m from the street's centre.
  std::vector<Vector3d> aroundBlock(int i, int j, double out, bool on_road) const {
    const Vector3d a = junction(i, j) + Vector3d(out, out, 0), c = junction(i + 1, j + 1) - Vector3d(out, out, 0);
    const std::array<Vector3d, 5> corners = {a, {a.x(), c.y(), 0}, c, {c.x(), a.y(), 0}, a};
    std::vector<Vector3d> path;
    for (std::size_t k = 0; k + 1 < corners.size(); ++k)
      for (int n = 0; n < 20; ++n) {
        const Vector3d p = corners[k] + (corners[k + 1] - corners[k]) * n / 20;
        path.push_back(on_road ? onRoad(p) : onPavement(p));
      }
    path.push_back(path.front());
    return path;
  }

  void addActors(World& world, RandomSequence& random) const {
    const auto add = [&](Label label, double out, bool on_road, double slow, double fast, const auto& build) {
      Actor actor;
      MeshBuilder b;
      build(b);
      actor.mesh = b.take();
      actor.label = label;
      actor.instance = static_cast<std::uint16_t>(30000 + world.actors.size());
      actor.path = aroundBlock(random.below(p_.blocks_x), random.below(p_.blocks_y), out, on_road);
      if (!on_road && random.uniform() < 0.5) std::reverse(actor.path.begin(), actor.path.end());
      actor.speed_mps = random.uniform(slow, fast);
      actor.start_m = random.uniform() * actor.pathLength();
      world.actors.push_back(std::move(actor));
    };
    for (int k = 0; k < p_.cars; ++k)
      add(Label::kCar, 1.6, true, 5, 10, [&](MeshBuilder& b) { addCar(b, Pose::Identity(), random); });
    for (int k = 0; k < p_.cyclists; ++k)
      add(Label::kBicyclist, 2.4, true, 3.5, 6, [&](MeshBuilder& b) { addCyclist(b, Pose::Identity(), random); });
    for (int k = 0; k < p_.people; ++k)
      add(Label::kPerson, p_.road_m / 2 + 1.7, false, 1, 1.7,
          [&](MeshBuilder& b) { addPerson(b, Pose::Identity(), random); });
  }

  void addRoutes(World& world) const {
    const int nx = p_.blocks_x, ny = p_.blocks_y;
    const auto route = [&](const std::string& name, bool closed, const std::vector<std::array<int, 2>>& junctions) {
      Route r{name, {}, closed};
      for (const auto& [i, j] : junctions) r.points.push_back(onRoad(junction(i, j)));
      world.routes.push_back(std::move(r));
    };
    route("around", true, {{0, 0}, {nx, 0}, {nx, ny}, {0, ny}});
    route("block", true, {{0, 0}, {1, 0}, {1, 1}, {0, 1}});
    if (nx >= 2 && ny >= 2) {
      route("eight", true, {{0, 1}, {2, 1}, {2, 2}, {1, 2}, {1, 0}, {0, 0}});
      route("there_and_back", false, {{0, 1}, {2, 1}, {2, 2}, {1, 2}, {1, 1}, {0, 1}});
    }
    std::vector<std::array<int, 2>> grid;
    for (int j = 0; j <= ny; ++j) {
      grid.push_back({j % 2 == 0 ? 0 : nx, j});
      grid.push_back({j % 2 == 0 ? nx : 0, j});
    }
    const bool from_right = ny % 2 == 0;
    for (int k = 0; k <= nx; ++k) {
      const int i = from_right ? nx - k : k;
      if (k > 0) grid.push_back({i, k % 2 == 0 ? ny : 0});
      grid.push_back({i, k % 2 == 0 ? 0 : ny});
    }
    route("all_streets", false, grid);
  }

  Params p_;
};

}  // namespace

}  // namespace scslam::sim

namespace scslam {
SCSLAM_REGISTER(sim::WorldGenerator, sim::Town, "town",
                "streets in a grid, with houses, parked cars, trees and traffic")
}
