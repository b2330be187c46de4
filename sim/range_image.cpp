#include "sim/range_image.h"

#include <complex>
#include <numbers>

#include "scslam/core/error.h"
#include "sim/statistics.h"

namespace scslam::sim {
namespace {

constexpr double kDeg = 180 / std::numbers::pi;
constexpr double kRingTolerance_deg = 0.1;
constexpr double kRowJump_deg = 5;  // the azimuth goes back by more only where a row ends
constexpr std::size_t kLeastPoints = 20;

/// A return in the sensor's own coordinates.
struct Return {
  std::int32_t index;
  double range_m, azimuth_deg, elevation_deg;
  int ring = -1;
};

std::vector<Return> returnsOf(const Cloud& cloud) {
  std::vector<Return> returns;
  returns.reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double x = cloud.x[i], y = cloud.y[i], z = cloud.z[i];
    const double range = std::sqrt(x * x + y * y + z * z);
    if (!std::isfinite(range) || range == 0) continue;
    returns.push_back(
        {static_cast<std::int32_t>(i), range, kDeg * std::atan2(y, x), kDeg * std::atan2(z, std::hypot(x, y))});
  }
  return returns;
}

void ringsAsGiven(const Cloud& cloud, int rings, std::vector<Return>& returns) {
  for (Return& r : returns) {
    r.ring = cloud.ring[static_cast<std::size_t>(r.index)];
    if (r.ring >= rings)
      throw inputError("a point is of ring {}, but the sensor table has {} rings; another --sensor?", r.ring, rings);
  }
}

/// Where the rows begin when each row's azimuth runs in `direction`; the end is the last entry.
std::vector<std::size_t> rowStarts(const std::vector<Return>& returns, double direction) {
  std::vector<std::size_t> starts = {0};
  for (std::size_t i = 1; i < returns.size(); ++i)
    if (direction * (returns[i].azimuth_deg - returns[i - 1].azimuth_deg) < -kRowJump_deg) starts.push_back(i);
  starts.push_back(returns.size());
  return starts;
}

/// One row a ring, in order of elevation? Then every point of a row is of its ring, whatever the beam's origin or a
/// deskewing did to its elevation.
bool ringsByRows(int rings, std::vector<Return>& returns) {
  for (const double direction : {1.0, -1.0}) {
    const auto starts = rowStarts(returns, direction);
    if (starts.size() != static_cast<std::size_t>(rings) + 1 || rings < 2) continue;
    std::vector<double> middle;
    for (std::size_t row = 0; row + 1 < starts.size(); ++row) {
      std::vector<double> elevations;
      for (std::size_t i = starts[row]; i < starts[row + 1]; ++i) elevations.push_back(returns[i].elevation_deg);
      middle.push_back(median(std::move(elevations)));
    }
    const bool rising = std::is_sorted(middle.begin(), middle.end());
    if (!rising && !std::is_sorted(middle.rbegin(), middle.rend())) continue;
    for (int row = 0; row < rings; ++row)
      for (std::size_t i = starts[static_cast<std::size_t>(row)]; i < starts[static_cast<std::size_t>(row) + 1]; ++i)
        returns[i].ring = rising ? row : rings - 1 - row;
    return true;
  }
  return false;
}

void ringsByElevation(const std::vector<double>& table_deg, std::vector<Return>& returns) {
  for (Return& r : returns) {
    const auto above = std::lower_bound(table_deg.begin(), table_deg.end(), r.elevation_deg);
    auto nearest = above == table_deg.end() ? above - 1 : above;
    if (above != table_deg.begin() && std::abs(*(above - 1) - r.elevation_deg) <= std::abs(*nearest - r.elevation_deg))
      nearest = above - 1;
    if (std::abs(*nearest - r.elevation_deg) < kRingTolerance_deg)
      r.ring = static_cast<int>(nearest - table_deg.begin());
  }
}

RingSource assignRings(const Cloud& cloud, const SensorModel& sensor, std::vector<Return>& returns) {
  if (cloud.hasRing()) {
    ringsAsGiven(cloud, sensor.rings, returns);
    return RingSource::kGiven;
  }
  if (ringsByRows(sensor.rings, returns)) return RingSource::kRows;
  if (sensor.elevation_deg.size() != static_cast<std::size_t>(sensor.rings))
    throw usageError("the points have no ring number and the table '{}' has no elevations to find it by", sensor.name);
  ringsByElevation(sensor.elevation_deg, returns);
  return RingSource::kElevation;
}

/// Lays one ring's returns into its row. The grid's phase is the circular mean of the azimuths modulo a step.
void layRow(const std::vector<const Return*>& row, int ring, RangeImage& image, std::vector<double>& off_step) {
  const double step_deg = 360.0 / image.columns;
  std::complex<double> sum = 0;
  for (const Return* r : row) sum += std::polar(1.0, 2 * std::numbers::pi * r->azimuth_deg / step_deg);
  const double phase = std::arg(sum) / (2 * std::numbers::pi);
  std::vector<double> elevations;
  for (const Return* r : row) {
    const double place = r->azimuth_deg / step_deg - phase, column = std::nearbyint(place);
    off_step.push_back(std::abs(place - column));
    elevations.push_back(r->elevation_deg);
    const int wrapped = (static_cast<int>(column) + 2 * image.columns) % image.columns;
    const std::size_t pixel = image.pixel(ring, wrapped);
    image.range_m[pixel] = r->range_m;
    image.point[pixel] = r->index;
  }
  if (row.size() < kLeastPoints) return;
  image.phase_step[static_cast<std::size_t>(ring)] = phase;
  image.elevation_deg[static_cast<std::size_t>(ring)] = median(std::move(elevations));
}

}  // namespace

const char* toString(RingSource source) {
  switch (source) {
    case RingSource::kGiven:
      return "as the points say";
    case RingSource::kRows:
      return "by the order of the points, row by row";
    case RingSource::kElevation:
      break;
  }
  return "by elevation";
}

RangeImage organise(const Cloud& cloud, const SensorModel& sensor) {
  if (sensor.rings < 1 || sensor.columns < 8)
    throw usageError("the sensor table '{}' does not say how many rings and columns there are", sensor.name);
  std::vector<Return> returns = returnsOf(cloud);
  const auto rings = static_cast<std::size_t>(sensor.rings);
  const std::size_t pixels = rings * static_cast<std::size_t>(sensor.columns);
  RangeImage image;
  image.rings = sensor.rings, image.columns = sensor.columns;
  image.range_m.assign(pixels, kNotMeasured);
  image.point.assign(pixels, -1);
  image.elevation_deg.assign(rings, kNotMeasured);
  image.phase_step.assign(rings, kNotMeasured);
  image.offered = returns.size();
  image.ring_source = assignRings(cloud, sensor, returns);
  std::vector<std::vector<const Return*>> rows(rings);
  for (const Return& r : returns)
    if (r.ring >= 0) rows[static_cast<std::size_t>(r.ring)].push_back(&r), ++image.on_ring;
  std::vector<double> off_step;
  for (int ring = 0; ring < image.rings; ++ring) layRow(rows[static_cast<std::size_t>(ring)], ring, image, off_step);
  image.azimuth_off_step = median(std::move(off_step));
  return image;
}

}  // namespace scslam::sim
