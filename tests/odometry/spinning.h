// The room of tests/support as a spinning LiDAR sees it: rings, columns, rays that end at the first surface.
#pragma once
#include <limits>
#include <random>
#include <vector>

#include "odometry/drive.h"

namespace scslam::test {

struct Box {
  Eigen::Vector3d low, high;
};

/// Inside of the first box, outside of the others. `period_m` > 0: the world repeats along x, without walls across it.
struct BoxWorld {
  std::vector<Box> boxes;
  double period_m = 0;

  /// Way along the ray to the first surface.
  double range(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) const {
    double nearest = inside(from, direction);
    for (std::size_t k = 1; k < boxes.size(); ++k) {
      if (period_m <= 0) nearest = std::min(nearest, entry(boxes[k], from, direction));
      for (int n = -2; period_m > 0 && n <= 2; ++n) {
        const Eigen::Vector3d shift((std::floor(from.x() / period_m) + n) * period_m, 0, 0);
        nearest = std::min(nearest, entry(boxes[k], from - shift, direction));
      }
    }
    return nearest;
  }

 private:
  double inside(const Eigen::Vector3d& from, const Eigen::Vector3d& d) const {
    double leave = std::numeric_limits<double>::infinity();
    for (int axis = period_m > 0 ? 1 : 0; axis < 3; ++axis)
      if (d[axis] != 0)
        leave = std::min(leave, ((d[axis] > 0 ? boxes[0].high : boxes[0].low)[axis] - from[axis]) / d[axis]);
    return leave;
  }
  static double entry(const Box& box, const Eigen::Vector3d& from, const Eigen::Vector3d& d) {
    double enter = 0, leave = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      double a = (box.low[axis] - from[axis]) / d[axis], b = (box.high[axis] - from[axis]) / d[axis];
      if (a > b) std::swap(a, b);
      enter = std::max(enter, a), leave = std::min(leave, b);
    }
    return enter < leave && enter > 0 ? enter : std::numeric_limits<double>::infinity();
  }
};

inline BoxWorld roomWorld() {
  return {{{{-10, -6, 0}, {10, 6, 4}},
           {{4, 2, 0}, {6, 3.5, 2.2}},
           {{-7, -4.5, 0}, {-6, -1.5, 1.2}},
           {{-3, 4, 0}, {-1.8, 5.2, 3}}}};
}

/// A street without end: two walls, with pillars and blocks at uneven places.
inline BoxWorld streetWorld() {
  return {{{{0, -8, 0}, {1, 8, 30}},
           {{3, 5, 0}, {3.6, 5.6, 5}},
           {{11, -7, 0}, {14, -5.5, 2}},
           {{19, 6, 0}, {22, 8, 3.5}},
           {{26, -6.5, 0}, {26.5, -6, 5}},
           {{33, -8, 0}, {34, -6, 4}}},
          40};
}

struct SpinningSensor {
  int rings = 32, columns = 360;
  double lowest_rad = -0.5, highest_rad = 0.3, noise_m = 0.01;
};

/// A scan at the instant of its stamp (nothing moves during the sweep), with rings and without recorded odometry.
inline Scan spunAt(std::size_t index, const Pose& T_world_base, const BoxWorld& world = roomWorld(),
                   const SpinningSensor& sensor = {}) {
  Scan scan;
  scan.index = index;
  scan.stamp = stampFromSeconds(1000.0 + 0.1 * static_cast<double>(index));
  scan.T_base_sensor = T_base_sensor();
  const Pose T_world_sensor = T_world_base * scan.T_base_sensor;
  std::mt19937 random(static_cast<std::uint32_t>(index) + 10);
  const auto uniform = [&random] { return static_cast<double>(random()) / 4294967296.0; };
  const double phase = uniform();  // a real head does not start where it started before
  for (int column = 0; column < sensor.columns; ++column) {
    for (int ring = 0; ring < sensor.rings; ++ring) {
      const double azimuth = 2 * M_PI * (column + phase) / sensor.columns;
      const double elevation = sensor.lowest_rad + (sensor.highest_rad - sensor.lowest_rad) * ring / (sensor.rings - 1);
      const Eigen::Vector3d d(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                              std::sin(elevation));
      double noise = 0;
      for (int j = 0; j < 4; ++j) noise += uniform() - 0.5;
      const double range = world.range(T_world_sensor.translation(), T_world_sensor.linear() * d);
      if (!(range < 150)) continue;
      const Eigen::Vector3f p = ((range + sensor.noise_m * 1.7 * noise) * d).cast<float>();
      scan.cloud.push(p.x(), p.y(), p.z());
      scan.cloud.ring.push_back(static_cast<std::uint16_t>(ring));
    }
  }
  scan.cloud.intensity.assign(scan.cloud.size(), 0.5f);
  return scan;
}

}  // namespace scslam::test
