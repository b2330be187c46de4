#include <algorithm>
#include <cmath>

#include "scslam/core/error.h"
#include "sim/lidar.h"

namespace scslam::sim {

namespace {

constexpr double kDeg = M_PI / 180;

/// Entry of a per-ring list that repeats.
double ofRing(const std::vector<double>& list, int ring) {
  return list.empty() ? 0 : list[static_cast<std::size_t>(ring) % list.size()];
}

bool isBlind(const std::vector<double>& blind_deg, double azimuth) {
  const double deg = azimuth / kDeg;
  for (std::size_t i = 0; i + 1 < blind_deg.size(); i += 2) {
    const double width = blind_deg[i + 1] - blind_deg[i];
    const double into = deg - blind_deg[i] - 360 * std::floor((deg - blind_deg[i]) / 360);
    if (into < width) return true;
  }
  return false;
}

}  // namespace

BeamGrid::BeamGrid(const SensorModel& sensor) : rings_(sensor.rings), columns_(sensor.columns) {
  if (rings_ < 1 || columns_ < 1)
    throw usageError("the sensor table '{}' states no rings or no columns: it cannot be simulated", sensor.name);
  if (sensor.elevation_deg.size() != static_cast<std::size_t>(rings_))
    throw usageError("the sensor table '{}' has {} rings but {} elevations", sensor.name, rings_,
                     sensor.elevation_deg.size());
  if (sensor.beams.blind_deg.size() % 2 != 0)
    throw usageError("the sensor table '{}': blind_deg needs pairs of azimuths", sensor.name);
  ring_bits_ = rings_ >= 4 ? 2 : 0, column_bits_ = 4 - ring_bits_;
  tiles_across_ = tileOf(0, rings_ - 1) + 1;
  tiles_ = tileOf(columns_ - 1, rings_ - 1) + 1;
  column_s_ = sensor.beams.column_s > 0 ? sensor.beams.column_s : sensor.sweep_s / columns_;
  directions_.assign(tiles_ * 48, 0);
  active_.assign(tiles_, 0);
  shares_.assign(tiles_ * 16, 0);
  const BeamTable& beams = sensor.beams;
  if (beams.origin_radius_m > 0 || !beams.height_m.empty() || !beams.lateral_m.empty()) origins_.assign(tiles_ * 48, 0);
  for (int r = 0; r < rings_; ++r) times_.push_back(ofRing(beams.time_us, r) * 1e-6);
  for (int r = 0; r < rings_; ++r)
    shift_.push_back(static_cast<int>(std::lround(ofRing(beams.azimuth_offset_deg, r) * columns_ / 360)) *
                     (sensor.clockwise ? 1 : -1));
  beams_have_times_ = std::any_of(times_.begin(), times_.end(), [](double t) { return t > 0; });
  for (std::size_t tile = 0; tile < tiles_; ++tile)
    for (int lane = 0; lane < 16; ++lane) addBeam(tile, lane, sensor);
}

void BeamGrid::addBeam(std::size_t tile, int lane, const SensorModel& sensor) {
  const int ring = std::min(ringOf(tile, lane), rings_ - 1), column = std::min(columnOf(tile, lane), columns_ - 1);
  const BeamTable& beams = sensor.beams;
  const double turn = (sensor.clockwise ? -1 : 1) * 2 * M_PI / columns_ / column_s_;  // [rad/s]
  const double head = beams.phase_deg * kDeg + turn * (columnTime(column) + beamTime(ring));
  const double azimuth = head + ofRing(beams.azimuth_offset_deg, ring) * kDeg;
  const double elevation = sensor.elevation_deg[static_cast<std::size_t>(ring)] * kDeg;
  float* direction = &directions_[tile * 48 + static_cast<std::size_t>(lane)];
  direction[0] = static_cast<float>(std::cos(elevation) * std::cos(azimuth));
  direction[16] = static_cast<float>(std::cos(elevation) * std::sin(azimuth));
  direction[32] = static_cast<float>(std::sin(elevation));
  shares_[tile * 16 + static_cast<std::size_t>(lane)] =
      std::min(1.0F, static_cast<float>((columnTime(column) + beamTime(ring)) / sweep()));
  if (!origins_.empty()) {
    float* origin = &origins_[tile * 48 + static_cast<std::size_t>(lane)];
    const double left = ofRing(beams.lateral_m, ring);
    origin[0] = static_cast<float>(beams.origin_radius_m * std::cos(head) - left * std::sin(azimuth));
    origin[16] = static_cast<float>(beams.origin_radius_m * std::sin(head) + left * std::cos(azimuth));
    origin[32] = static_cast<float>(ofRing(beams.height_m, ring));
  }
  const bool exists = ringOf(tile, lane) < rings_ && columnOf(tile, lane) < columns_;
  if (exists && !isBlind(beams.blind_deg, azimuth)) active_[tile] |= 1U << lane;
}

}  // namespace scslam::sim
