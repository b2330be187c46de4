// What radars show that is not there: streaks of a saturated receiver, echoes by way of the car, single speckles.
#pragma once
#include "scslam/core/cloud.h"
#include "scslam/core/params.h"
#include "scslam/sensor/radar_scan.h"

namespace scslam {

struct RadarFilterParams : ParamSetOf<RadarFilterParams> {
  bool enabled = true;
  double streak_rise = 25;      ///< [grey levels]
  double streak_contrast = 30;  ///< [grey levels]
  double most_median = 128;     ///< [grey levels]
  int multipath_order = 3;
  double multipath_drop = 20;  ///< [grey levels]
  double multipath_tolerance_m = 0.7;
  int speckle_neighbours = 1;
  double speckle_range_m = 0.6;
  void describe(ParamVisitor& visitor) override;
};

struct RadarFilterReport {
  std::size_t streaks = 0;    ///< points of azimuths whose noise is raised
  std::size_t multipath = 0;  ///< points behind a stronger one, at a multiple of its range
  std::size_t speckle = 0;    ///< points without company in the azimuths beside theirs
  std::size_t raised_azimuths = 0;
  std::size_t removed() const { return streaks + multipath + speckle; }
};

/// Removes from the points of an extractor (ring = azimuth, ranges rising within each):
/// - in an azimuth whose median power is more than streak_rise above the median azimuth's, what is not streak_contrast
///   above its median; everything where that median is above most_median;
/// - a point near m times the range of one in the same azimuth that is multipath_drop stronger, m = 2 … multipath_order
///   (the wave that goes between car and wall m times);
/// - a point with fewer than speckle_neighbours other points within speckle_range_m of its range in the two azimuths
///   next to it on either side: the beam is wider than their distance.
RadarFilterReport filterRadarPoints(Cloud& cloud, const RadarScan& scan, const RadarFilterParams& params);

}  // namespace scslam
