// What a spinning radar's images do not say of themselves. Data in configs/sensors/navtech_*.yaml, group `radar`.
#pragma once
#include "scslam/core/params.h"
#include "scslam/sensor/radar_scan.h"

namespace scslam {

struct RadarTable : ParamSetOf<RadarTable> {
  double range_resolution_m = 0;  ///< width of a range bin; 0: no radar, or what the recording says
  double range_offset_m = 0;      ///< to be added to a bin's nominal range
  /// Range shown less true range, by range rate; 0: no such error. Carrier over slope of the frequency ramp: K.
  /// Burnett, A. Schoellig, T. Barfoot, "Do we need to compensate for motion distortion and Doppler effects in spinning
  /// radar navigation?", RA-L 2021.
  double doppler_beta_s = 0;
  double first_azimuth_deg = 0;  ///< where the first row of an image without encoder looks, clockwise from x
  std::string stamp = "start";   ///< which azimuth an image's one stamp belongs to: start, middle or end of the sweep
  bool validity = true;          ///< byte 10 of Oxford's layout says whether an azimuth was measured
  void describe(ParamVisitor& visitor) override;
};

/// Resolution, offset and Doppler factor of `table` for a sweep, where it has them.
void applyTable(const RadarTable& table, RadarScan& sweep);

}  // namespace scslam
