// Scans whose figures are known beforehand: a sensor in the axis of a wide vertical pipe that stands on flat ground.
#pragma once
#include <cmath>
#include <random>

#include "scslam/core/cloud.h"
#include "scslam/sensor/sensor_model.h"

namespace scslam::test {

struct PipeScan {
  double radius_m = 12;
  double ground_m = 1.7;     ///< depth of the ground below the sensor; 0 = none
  double noise_m = 0;        ///< sigma along the beam
  double quantum_m = 0.001;  ///< 0 = none
  double dropout = 0;        ///< rate where the signal is 50 counts
  double weak_dropout = 0;   ///< rate where the signal is 9 counts: azimuths of 0 … 180 deg
  bool ring = true, time = true, signal = true;
};

inline SensorModel aSensor(int rings = 16, int columns = 1024) {
  SensorModel sensor;
  sensor.name = "synthetic";
  sensor.rings = rings, sensor.columns = columns;
  for (int k = 0; k < rings; ++k) sensor.elevation_deg.push_back(-15.5 + 31.0 * k / (rings - 1));
  return sensor;
}

/// Row by row, lowest ring first, azimuth falling with time (clockwise). Deterministic in `seed`.
inline Cloud scanOf(const PipeScan& pipe, const SensorModel& sensor, std::uint32_t seed = 1) {
  std::mt19937 random(seed);
  const auto uniform = [&random] { return static_cast<double>(random()) / 4294967296.0; };
  const auto gaussian = [&] {
    double sum = 0;
    for (int i = 0; i < 12; ++i) sum += uniform() - 0.5;
    return sum;
  };
  Cloud cloud;
  for (int ring = 0; ring < sensor.rings; ++ring)
    for (int fired = 0; fired < sensor.columns; ++fired) {
      const double elevation = sensor.elevation_deg[static_cast<std::size_t>(ring)] * M_PI / 180;
      const double azimuth = M_PI - 2 * M_PI * (fired + 0.3) / sensor.columns;
      double range = pipe.radius_m / std::cos(elevation);
      if (pipe.ground_m > 0 && elevation < 0) range = std::min(range, pipe.ground_m / -std::sin(elevation));
      range += pipe.noise_m * gaussian();
      if (pipe.quantum_m > 0) range = pipe.quantum_m * std::nearbyint(range / pipe.quantum_m);
      const bool weak = azimuth > 0;
      if (uniform() < (weak ? pipe.weak_dropout : pipe.dropout)) continue;
      cloud.push(static_cast<float>(range * std::cos(elevation) * std::cos(azimuth)),
                 static_cast<float>(range * std::cos(elevation) * std::sin(azimuth)),
                 static_cast<float>(range * std::sin(elevation)));
      if (pipe.ring) cloud.ring.push_back(static_cast<std::uint16_t>(ring));
      if (pipe.time) cloud.dt.push_back(static_cast<float>(sensor.sweep_s * fired / sensor.columns));
      if (pipe.signal) cloud.intensity.push_back(weak ? 9.0f : 50.0f);
    }
  return cloud;
}

}  // namespace scslam::test
