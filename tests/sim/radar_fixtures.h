// Small worlds and drives for the radar's tests.
#pragma once
#include <cmath>

#include "scslam/core/file.h"
#include "sim/mesh_builder.h"
#include "sim/radar.h"
#include "support/support.h"

namespace scslam::sim::test {

inline World worldOf(MeshBuilder& builder) {
  World world;
  world.name = "test";
  world.mesh = builder.take();
  return world;
}

/// Along x at a constant speed, at (0, 0, 0) at time 0.
inline Trajectory straight(double speed_mps = 0) {
  std::vector<Pose> control;
  for (int i = -1; i < 12; ++i) control.push_back(poseFromYaw(0, {0.2 * i * speed_mps, 0, 0}));
  return {control, 0.2};
}

/// The shipped CTS350-X in the base's origin.
inline RadarModel shipped(const std::string& name = "cts350-x") {
  RadarModel model;
  const std::string file = std::string(SCSLAM_SOURCE_DIR) + "/sim/radars/" + name + ".yaml";
  loadYaml(model, readFile(file), file);
  return model;
}
inline RadarModel bare() {
  RadarModel model = shipped();
  model.translation_m = {0, 0, 0};
  model.noise = 0, model.speckle = false, model.max_bounces = 1, model.saturation_db = 120;
  return model;
}

inline RadarScan scanOf(const RadarModel& model, const World& world, const Trajectory& drive = straight(),
                        double start_s = 0, std::uint64_t seed = 1, std::uint32_t number = 0, int threads = 2) {
  ThreadPool pool(threads);
  RayScene scene(world);
  scene.poseActors(start_s, start_s + model.sweep());
  return Radar(model, seed).scan(scene, drive, start_s, number, pool, &world);
}

/// Power of a level of half a decibel.
inline double powerOf(std::uint8_t level) { return level == 0 ? 0 : std::pow(10.0, (level + 0.4) / 20); }

/// A box of metal whose nearest face is `range` away, square to the line from the origin, `azimuth` clockwise.
inline void boxAt(MeshBuilder& builder, double range, double azimuth, double size = 0.4) {
  const Eigen::Vector3d d(std::cos(azimuth), -std::sin(azimuth), 0);
  builder.material("metal").box(d * (range + size / 2) - Eigen::Vector3d(0, 0, size / 2), size, size, size, -azimuth);
}

/// Where an image is strongest: row and bin with fractions (parabolas of the levels), and its level.
struct Peak {
  double row, position, level;
};
inline Peak peakOf(const RadarScan& scan) {
  const auto at = static_cast<std::size_t>(std::max_element(scan.power.begin(), scan.power.end()) - scan.power.begin());
  const std::size_t bins = scan.bins, rows = scan.azimuths, row = at / bins, bin = at % bins;
  const auto top = [](double a, double b, double c) { return (a - c) / (2 * (a - 2 * b + c)); };
  const auto level = [&](std::size_t r, std::size_t b) { return static_cast<double>(scan.power[r % rows * bins + b]); };
  const double across = top(level(row + rows - 1, bin), level(row, bin), level(row + 1, bin));
  constexpr std::size_t kStep = 8;
  const double along = kStep * top(level(row, bin - kStep), level(row, bin), level(row, bin + kStep));
  return {static_cast<double>(row) + across, static_cast<double>(bin) + 0.5 + along, level(row, bin)};
}

/// A street of 12 m between houses with gaps; poles, cars (boxes) and trees; grass beyond.
inline World aStreet() {
  MeshBuilder b;
  RandomSequence random(CounterRandom(3, RandomStream::kWorld));
  const auto rough = [](double x, double y) { return 0.02 * std::sin(1.7 * x) * std::cos(1.3 * y); };
  b.material("asphalt").terrain(-170, -6, 170, 6, 1.5, rough);
  b.material("grass").terrain(-170, -60, 170, -6, 3, rough);
  b.material("grass").terrain(-170, 6, 170, 60, 3, rough);
  for (const double side : {-1.0, 1.0}) {
    for (double x = -165; x < 165; x += random.uniform(12, 22)) {
      const double length = random.uniform(8, 12), y = side * random.uniform(12, 15);
      b.material(random.below(2) == 0 ? "brick" : "plaster");
      b.box({x, y, 0}, length, 8, random.uniform(5, 10), random.normal() * 0.02);
      for (int window = 0; window < 3; ++window)
        b.material("glass").box({x - 3 + 3 * window, y - side * 4.02, 1}, 1.2, 0.1, 1.4);
    }
    for (double x = -160; x < 160; x += 7)
      if (random.uniform() < 0.4)
        b.material("car_paint").box({x, side * 4.6, 0.3}, 4.2, 1.7, 1.2, random.normal() * 0.03);
    for (double x = -160; x < 160; x += random.uniform(18, 30))
      b.material("pole").cylinder({x, side * 6.5, 0}, {x, side * 6.5, 7}, 0.08);
    for (double x = -150; x < 150; x += random.uniform(15, 40))
      b.material("leaves").foliage({x, side * random.uniform(7, 25), 4}, {2.2, 2.2, 2.4}, 12, 0.15, random);
  }
  return worldOf(b);
}

}  // namespace scslam::sim::test
