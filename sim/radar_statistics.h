// What a radar image looks like in numbers, to hold a simulated one against a real one.
#pragma once
#include <array>
#include <string>

#include "scslam/sensor/radar_scan.h"

namespace scslam::sim {

/// Grey levels are those of the image (0 … 255). The quiet area is the farthest quarter of the bins.
struct RadarStatistics {
  static constexpr std::array<double, 7> kPercents = {1, 5, 25, 50, 75, 95, 99};

  double zeros = 0;                                       ///< share of exact zeros
  double quiet_mean = 0, quiet_sigma = 0, quiet_p99 = 0;  ///< of the quiet area
  double azimuth_correlation = 0;                         ///< of neighbouring rows, means of the columns taken off
  std::array<double, 3> range_correlation{};              ///< 1, 2 and 4 bins apart, mean of each row taken off
  std::array<double, 3> quiet_range_correlation{};        ///< the same within the quiet area (noise alone)
  double quiet_azimuth_correlation = 0;                   ///< the same across rows
  double strong = 0;      ///< bins an azimuth that are above the threshold (quiet mean + 3 sigma + 20), at most 12
  double strong_all = 0;  ///< the same without the limit
  double saturated = 0;   ///< share of bins at 255
  std::array<double, kPercents.size()> percentiles{};  ///< of all bins
  std::array<double, 8> profile{};                     ///< mean over each eighth of the bins, nearest first
};

/// Rows that are not valid are left out. An empty image gives zeros.
RadarStatistics statisticsOf(const RadarScan& scan);
/// A table of two columns, one figure a line.
std::string compareStatistics(const std::string& name_a, const RadarStatistics& a, const std::string& name_b,
                              const RadarStatistics& b);

}  // namespace scslam::sim
