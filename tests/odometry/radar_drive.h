// The room of spinning.h as a spinning radar sees it: a power image, and the points a run takes from it.
#pragma once
#include <algorithm>

#include "odometry/spinning.h"
#include "scslam/core/counter_random.h"
#include "scslam/sensor/radar_extractor.h"

namespace scslam::test {

struct RadarSensor {
  std::size_t azimuths = 800, bins = 600;
  double range_resolution_m = 0.0432, noise_m = 0.01;
  double height_m = 1;        ///< of the plane it looks in, above the floor
  double sweep_s = 0;         ///< 0: the sweep is taken at one instant
  double doppler_beta_s = 0;  ///< as RadarScan's
};

/// How well a wall reflects at (x, y), the same from everywhere: 60 … 140 grey levels, in patches of 0.4 m.
inline double reflectivity(double x, double y) {
  const auto patch = [](double v) {
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::floor(v / 0.4)));
  };
  return 60 + 80 * static_cast<double>(uniformOf(CounterRandom(3, RandomStream::kWorld).block(patch(x), patch(y))[0]));
}

/// @param twist of the base during the sweep, frame base at its start: (v, w).
inline Scan radarAt(std::size_t index, const Pose& T_world_base, const BoxWorld& world = roomWorld(),
                    const RadarSensor& sensor = {}, const Vector6d& twist = Vector6d::Zero()) {
  auto image = std::make_shared<RadarScan>();
  image->resize(sensor.azimuths, sensor.bins);
  image->range_resolution_m = sensor.range_resolution_m, image->doppler_beta_s = sensor.doppler_beta_s;
  image->T_base_sensor = T_base_sensor();
  const Stamp start = stampFromSeconds(1000.0 + std::max(0.1, sensor.sweep_s) * static_cast<double>(index));
  RandomSequence random(CounterRandom(index + 10, RandomStream::kRadar));
  for (std::size_t a = 0; a < sensor.azimuths; ++a) {
    const double dt = sensor.sweep_s * static_cast<double>(a) / static_cast<double>(sensor.azimuths);
    image->angles[a] = 2 * M_PI * static_cast<double>(a) / static_cast<double>(sensor.azimuths);
    image->stamps[a] = start + std::chrono::duration_cast<Stamp::duration>(std::chrono::duration<double>(dt));
    const Pose T_start_now = retract(Pose::Identity(), dt * twist);
    const Pose T_world_sensor = T_world_base * T_start_now * image->T_base_sensor;
    const Eigen::Vector3d d = T_world_sensor.linear() * image->direction(a);
    Eigen::Vector3d from = T_world_sensor.translation();
    from.z() = sensor.height_m;
    const double range = world.range(from, d);
    const Eigen::Vector3d hit = from + range * d;
    const Eigen::Vector3d velocity =
        T_world_base.linear() *
        (twist.head<3>() + T_start_now.linear() * twist.tail<3>().cross(image->T_base_sensor.translation()));
    const double shown = range - sensor.doppler_beta_s * velocity.dot(d) + sensor.noise_m * random.normal();
    const double top = reflectivity(hit.x(), hit.y()), position = shown / sensor.range_resolution_m;
    for (std::size_t bin = 0; bin < sensor.bins; ++bin) {
      const double x = (static_cast<double>(bin) + 0.5 - position) / 8;
      image->row(a)[bin] = static_cast<std::uint8_t>(std::max(0.0, std::round(top * (1 - 0.5 * x * x))));
    }
  }
  Scan scan;
  scan.index = index, scan.stamp = start;
  scan.T_base_sensor = image->T_base_sensor, scan.planar = true;
  scan.radar = image;
  auto params = Registry<RadarExtractor>::instance().find("k_strongest").defaults();
  setParam(*params, "min_range_m=0.5");
  scan.cloud = Registry<RadarExtractor>::instance().create("k_strongest", *params, context())->extract(*image);
  return scan;
}

}  // namespace scslam::test
