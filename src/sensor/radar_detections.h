// What all radar extractors share: rows in parallel, exact peak positions, points of detections.
#pragma once
#include <functional>
#include <span>
#include <vector>

#include "scslam/core/cloud.h"
#include "scslam/core/parallel.h"
#include "scslam/core/params.h"
#include "scslam/sensor/radar_scan.h"

namespace scslam {

/// Something that gave an echo in a row.
struct RadarDetection {
  float position = 0;  ///< in bins: the middle of bin i is i + 0.5
  float power = 0;     ///< as the sensor's, 0 … 255
};

/// Parameters that every extractor has.
struct RadarWindowParams {
  double min_range_m = 2.5;    ///< nearer bins show the antenna's own coupling and the car
  double max_range_m = 200.0;  ///< true ranges, offset included
  double echo_width_m = 0.4;   ///< of a point target's echo: peaks are fitted over it

  void describeWindow(ParamVisitor& v);

  struct Bins {
    std::size_t begin = 0, end = 0;  ///< [begin, end) is looked at
    std::size_t half_width = 1;      ///< of an echo
  };
  /// In bins of `scan`; empty for an image without bins or with an absurd resolution.
  Bins binsOf(const RadarScan& scan) const;
};

/// Where a peak around bin `at` really is: vertex of the parabola of least squares through the bins within half_width
/// (an echo of Gaussian shape is one in a logarithmic receiver); the middle of the run of bins as high as `at` where
/// the fit has no maximum within half of half_width. A row's ends shorten the window on both sides.
RadarDetection refinedPeak(std::span<const std::uint8_t> row, std::size_t at, std::size_t half_width);

/// Bins of [begin, end) that are at least `floor` and higher than all bins within half_width before, not lower than
/// those behind: of an echo with a flat top the first bin.
void findPeaks(std::span<const std::uint8_t> row, const RadarWindowParams::Bins& bins, int floor,
               std::vector<std::size_t>& peaks);

/// Runs detect(azimuth, detections) for each valid row, in parallel, and makes points of what was found: sensor frame,
/// z = 0, azimuth by azimuth in the order of the row's detections (outwards; one that does not lie farther than the one
/// before is left out), intensity = power, ring = azimuth,
/// dt = seconds after the first azimuth's stamp.
Cloud radarCloud(const RadarScan& scan, ThreadPool& threads,
                 const std::function<void(std::size_t azimuth, std::vector<RadarDetection>& detections)>& detect);

}  // namespace scslam
