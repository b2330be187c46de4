// A scan laid out as its sensor fires: one row a ring, one column a firing.
#pragma once
#include <cstdint>
#include <vector>

#include "scslam/core/cloud.h"
#include "scslam/sensor/sensor_model.h"

namespace scslam::sim {

/// How the ring of a point was known.
enum class RingSource {
  kGiven,      ///< the cloud says it
  kRows,       ///< the points come row by row: azimuth rises (or falls) within a row, one row a ring
  kElevation,  ///< the nearest elevation of the table, within 0.1 deg; points farther from all rings are left out
};
const char* toString(RingSource source);

struct RangeImage {
  int rings = 0, columns = 0;
  std::vector<double> range_m;      ///< rings x columns, row by row, lowest ring first; NaN: no return
  std::vector<std::int32_t> point;  ///< index into the cloud, -1: no return
  std::size_t offered = 0;          ///< points of the cloud that are a return: finite and not the origin
  std::size_t on_ring = 0;          ///< of these, the ones given a ring
  RingSource ring_source = RingSource::kGiven;
  std::vector<double> elevation_deg;  ///< per ring: median of its points; NaN below 20 points
  std::vector<double> phase_step;     ///< per ring: azimuth of column 0 in steps of 360 deg / columns, [-0.5, 0.5]
  double azimuth_off_step = 0;        ///< median distance of the azimuths from their ring's grid, in steps; 0.25 = none

  std::size_t pixel(int ring, int column) const {
    return static_cast<std::size_t>(ring) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
  }
  /// Columns wrap around.
  double at(int ring, int column) const { return range_m[pixel(ring, (column + columns) % columns)]; }
  bool returned(int ring, int column) const { return point[pixel(ring, (column + columns) % columns)] >= 0; }
};

/// @param cloud frame: sensor, of one sweep. Of two points in one pixel the later one stays.
/// @param sensor rings and columns must be known, and the elevations unless the cloud says the rings.
/// @throw usageError when the table does not say enough; inputError when a ring number is beyond the table's.
RangeImage organise(const Cloud& cloud, const SensorModel& sensor);

}  // namespace scslam::sim
