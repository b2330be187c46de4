// One sweep of a spinning radar: power over azimuth and range.
#pragma once
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "scslam/core/pose.h"
#include "scslam/core/stamp.h"

namespace scslam {

/// Row i was measured at stamps[i] with the antenna at angles[i]. Sensor frame: x forward, y left, z up; the encoder
/// counts clockwise seen from above, from the x axis (Navtech, and with it Oxford, MulRan and Boreas).
struct RadarScan {
  std::size_t azimuths = 0, bins = 0;
  std::vector<std::uint8_t> power;  ///< azimuths x bins, row by row, as the sensor gives it (no unit)
  std::vector<Stamp> stamps;        ///< per azimuth
  std::vector<double> angles;       ///< per azimuth: encoder [rad], 0 … 2 pi, clockwise
  std::vector<std::uint8_t> valid;  ///< per azimuth: 0 = not measured; else as the sensor wrote it (mostly 255)
  double range_resolution_m = 0;    ///< width of a bin
  double range_offset_m = 0;        ///< what to add to a bin's nominal range to get the true one
  double doppler_beta_s = 0;        ///< what a range rate of 1 m/s adds to the range shown (approaching looks nearer)
  std::string label;                ///< of the sensor
  Pose T_base_sensor = Pose::Identity();

  /// A sweep of zeros, all valid, whose stamps and angles are still to be set.
  void resize(std::size_t azimuth_count, std::size_t bin_count) {
    azimuths = azimuth_count, bins = bin_count;
    power.assign(azimuths * bins, 0);
    stamps.assign(azimuths, Stamp{});
    angles.assign(azimuths, 0);
    valid.assign(azimuths, 255);
  }
  std::span<const std::uint8_t> row(std::size_t azimuth) const { return {power.data() + azimuth * bins, bins}; }
  std::span<std::uint8_t> row(std::size_t azimuth) { return {power.data() + azimuth * bins, bins}; }
  /// True range [m] of a position in a row; the middle of bin i is i + 0.5.
  double rangeAt(double position) const { return position * range_resolution_m + range_offset_m; }
  /// Unit vector of a row's beam in the sensor frame.
  Eigen::Vector3d direction(std::size_t azimuth) const {
    return {std::cos(angles[azimuth]), -std::sin(angles[azimuth]), 0};
  }
  /// All vectors have the size they should have.
  bool consistent() const {
    return power.size() == azimuths * bins && stamps.size() == azimuths && angles.size() == azimuths &&
           valid.size() == azimuths;
  }
};

}  // namespace scslam
