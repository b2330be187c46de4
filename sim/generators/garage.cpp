// A parking garage: identical storeys above each other, joined by straight ramps for up and down side by side.
//
//   y                  x: 0 … size, y: 0 … kWidth, storey k at z = k * storey_m
//   34 +-----------------------------------+   bays along both long walls (5 m deep),
//      |  aisle                            |   an aisle before each, in the middle the ramps,
//      |      <- ramp down (y 17 … 22.5)   |   which rise towards +x from x = 20 on.
//      |      -> ramp up   (y 11.5 … 17)   |
//      |  aisle                            |
//    0 +-----------------------------------+
//
// Routes: "up_and_down", closed, from the northern aisle of the ground floor heading west (-x) by all ramps to the top
// and back; "ground", closed, around the ground floor counter-clockwise.
#include <cmath>

#include "sim/props.h"
#include "sim/scenery.h"
#include "sim/world_generator.h"

namespace scslam::sim {
namespace {

using Eigen::Vector3d;

constexpr double kWidth = 34, kRampX = 20, kRampLow = 11.5, kRampMiddle = 17, kRampHigh = 22.5, kSlab = 0.25;  // [m]
constexpr double kWest = 8.5, kSouthAisle = 7.75, kNorthAisle = 26.25, kUp = 14.25, kDown = 19.75;

class Garage : public WorldGenerator {
 public:
  struct Params : ParamSetOf<Params> {
    int levels = 3;
    double storey_m = 2.8, ramp_slope = 0.12, occupancy = 0.35;
    void describe(ParamVisitor& v) override {
      v.field("levels", levels, "storeys", 1, 20);
      v.field("storey_m", storey_m, "from floor to floor; the slabs are 0.25 m thick [m]", 2.5, 6);
      v.field("ramp_slope", ramp_slope, "rise of the ramps over their length in plan", 0.04, 0.25);
      v.field("occupancy", occupancy, "share of bays with a parked car", 0, 1);
    }
  };

  Garage(const Params& params, const PluginContext&) : params_(params) {
    ramp_ = params_.storey_m / params_.ramp_slope;
    size_ = 2 * kRampX + ramp_;
  }

  World generate(std::uint64_t seed) const override {
    MeshBuilder builder;
    for (int k = 0; k < params_.levels; ++k) addStorey(builder, k);
    addSlab(builder, params_.levels * params_.storey_m, false);
    RandomSequence random(CounterRandom(seed, RandomStream::kWorld));
    for (int k = 0; k < params_.levels; ++k) addCars(builder, k * params_.storey_m, random);
    World world;
    world.name = "garage";
    world.mesh = builder.take();
    world.routes = {{"up_and_down", upAndDown(), true}, {"ground", aisles(0), true}};
    return world;
  }

 private:
  double east() const { return kRampX + ramp_ + kRampX - kWest; }
  double rampEnd() const { return kRampX + ramp_; }

  Line aisles(double z) const {
    return {{kWest, kSouthAisle, z}, {east(), kSouthAisle, z}, {east(), kNorthAisle, z}, {kWest, kNorthAisle, z}};
  }

  Line upAndDown() const {
    const double middle = kRampX + ramp_ / 2, h = params_.storey_m;
    const int top = params_.levels - 1;
    if (top == 0) return aisles(0);
    Line line = {{middle, kNorthAisle, 0}};
    for (int k = 0; k <= top; ++k) {
      const double z = k * h;
      line.emplace_back(kWest, kNorthAisle, z);
      if (k == top) break;
      line.emplace_back(kWest, kUp, z);
      line.emplace_back(kRampX, kUp, z);
      line.emplace_back(rampEnd(), kUp, z + h);
      line.emplace_back(east(), kUp, z + h);
      line.emplace_back(east(), kNorthAisle, z + h);
    }
    for (int k = top; k >= 0; --k) {
      const double z = k * h;
      line.emplace_back(kWest, kSouthAisle, z);
      line.emplace_back(east(), kSouthAisle, z);
      if (k == 0) break;
      line.emplace_back(east(), kDown, z);
      line.emplace_back(rampEnd(), kDown, z);
      line.emplace_back(kRampX, kDown, z - h);
      line.emplace_back(kWest, kDown, z - h);
    }
    line.emplace_back(east(), kNorthAisle, 0);
    return line;
  }

  void plate(MeshBuilder& builder, double x0, double x1, double y0, double y1, double top) const {
    builder.box({(x0 + x1) / 2, (y0 + y1) / 2, top - kSlab}, x1 - x0, y1 - y0, kSlab);
  }

  /// A slab with its top at z, with the opening for the ramps or without.
  void addSlab(MeshBuilder& builder, double z, bool opening) const {
    builder.material("concrete");
    if (!opening) return plate(builder, 0, size_, 0, kWidth, z);
    plate(builder, 0, size_, 0, kRampLow, z);
    plate(builder, 0, size_, kRampHigh, kWidth, z);
    plate(builder, 0, kRampX, kRampLow, kRampHigh, z);
    plate(builder, rampEnd(), size_, kRampLow, kRampHigh, z);
  }

  void addStorey(MeshBuilder& builder, int k) const {
    const double z = k * params_.storey_m, h = params_.storey_m - kSlab;
    addSlab(builder, z, k > 0);
    if (k + 1 < params_.levels) {  // the ramp to the next storey, with a kerb in its middle
      const auto slope = [&](double y0, double y1, double above, double thick) {
        builder.prism(poseFromYaw(0, {kRampX, 0, z + above}),
                      {{0, -thick}, {ramp_, params_.storey_m - thick}, {ramp_, params_.storey_m}, {0, 0}}, y0, y1);
      };
      builder.material("concrete");
      slope(kRampLow, kRampHigh, 0, kSlab);
      builder.material("kerb");
      slope(kRampMiddle - 0.15, kRampMiddle + 0.15, 0.12, 0.12);
    }
    builder.material("concrete");
    for (const double y : {kRampLow - 0.1, kRampHigh + 0.1})  // parapets along the ramps
      builder.box({kRampX + ramp_ / 2, y, z}, ramp_, 0.15, 0.9);
    for (const double y : {-0.1, kWidth + 0.1}) builder.box({size_ / 2, y, z - kSlab}, size_ + 0.4, 0.2, h + kSlab);
    for (const double x : {-0.1, size_ + 0.1}) builder.box({x, kWidth / 2, z - kSlab}, 0.2, kWidth, h + kSlab);
    addStructure(builder, z, h);
  }

  /// Pillars, beams under the ceiling, a pipe, lamps, markings of the bays.
  void addStructure(MeshBuilder& builder, double z, double h) const {
    const int spans = static_cast<int>(size_ / 8);
    for (int i = 1; i < spans; ++i) {
      const double x = size_ * i / spans;
      builder.material("concrete");
      for (const double y : {5.0, kWidth - 5}) builder.box({x, y, z}, 0.4, 0.4, h);
      if (x > kRampX && x < rampEnd())
        for (const double y : {kRampLow - 0.4, kRampHigh + 0.4}) builder.box({x, y, z}, 0.4, 0.4, h);
      for (const double y : {kRampLow / 2, kWidth - kRampLow / 2}) builder.box({x, y, z + h - 0.3}, 0.3, kRampLow, 0.3);
      builder.newInstance().material("metal");
      for (const double y : {kSouthAisle + 1.5, kNorthAisle - 1.5})
        builder.box({x + size_ / spans / 2, y, z + h - 0.12}, 1.2, 0.15, 0.1);
      builder.noInstance();
    }
    builder.material("metal").cylinder({0.1, 1.2, z + h - 0.45}, {size_ - 0.1, 1.2, z + h - 0.45}, 0.1, 8);
    builder.material("road_marking");
    for (int i = 0; i <= bays(); ++i)
      for (const double y : {0.0, kWidth - 5}) {
        const double x = bayX(i) - 1.25;
        builder.quad({x - 0.05, y, z + 0.004}, {x + 0.05, y, z + 0.004}, {x + 0.05, y + 5, z + 0.004},
                     {x - 0.05, y + 5, z + 0.004});
      }
  }

  int bays() const { return static_cast<int>((size_ - 8) / 2.6); }
  double bayX(int i) const { return 4 + 1.3 + 2.6 * i; }

  void addCars(MeshBuilder& builder, double z, RandomSequence& random) const {
    for (int i = 0; i < bays(); ++i)
      for (const bool north : {false, true}) {
        const bool taken = random.uniform() < params_.occupancy, reversed = random.uniform() < 0.3;
        const double yaw = (north != reversed ? M_PI / 2 : -M_PI / 2) + random.uniform(-0.04, 0.04);
        const Vector3d at(bayX(i) + random.uniform(-0.1, 0.1), north ? kWidth - 2.6 : 2.6, z);
        RandomSequence own = random;
        if (taken) addCar(builder, poseFromYaw(yaw, at), own, CarBody::kCar);
        for (int skip = 0; skip < 2; ++skip) random.uniform();
      }
  }

  Params params_;
  double ramp_ = 0, size_ = 0;  ///< length of a ramp and of the building [m]
};

}  // namespace

SCSLAM_REGISTER(sim::WorldGenerator, sim::Garage, "garage",
                "parking garage: identical storeys, ramps, pillars, parked cars")

}  // namespace scslam::sim
