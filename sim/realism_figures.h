// The figures by which scans are compared, of one scan or of a set. A new figure is one more field and one more line in
// describe(): reading, writing, the median over scans and the printed tables follow.
#pragma once
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "scslam/core/params.h"
#include "sim/statistics.h"

namespace scslam::sim {

// Upper edges are open. The lists of the figures follow these bins.
inline constexpr std::array kRangeHistogram_m = {0., 5., 10., 15., 20., 30., 40., 60., 80., 120.};  ///< and beyond
inline constexpr std::array kNoiseBins_m = {2., 5., 10., 15., 20., 30., 40., 60., 90.};
inline constexpr std::array kDropoutBins_m = {2., 20., 50., 120.};
inline constexpr std::array kSignalBins = {0., 6., 8., 10., 12., 15., 20., 30., 50., 80., 120., 200., 400.};
inline constexpr std::array kSpacingBins_m = {2., 10., 20., 40., 80.};

/// Bin of `value` among `edges`; -1 outside of them.
template <std::size_t N>
int binOf(const std::array<double, N>& edges, double value) {
  if (!(value >= edges.front() && value < edges.back())) return -1;
  return static_cast<int>(std::upper_bound(edges.begin(), edges.end(), value) - edges.begin()) - 1;
}

/// NaN = not measured. Of a set: the median over its scans, except where the comment says otherwise.
struct RealismFigures : ParamSetOf<RealismFigures> {
  int scans = 0;
  // The grid
  double elevation_off_deg = kNotMeasured;   ///< largest |median elevation - table| of a ring, over the set
  double on_ring_share = kNotMeasured;       ///< returns given a ring
  double azimuth_off_step = kNotMeasured;    ///< distance from the azimuth grid of the ring, in steps
  double azimuth_drift_step = kNotMeasured;  ///< largest change of a ring's phase within the set, in steps
  double range_quantum_m = kNotMeasured;     ///< 0: no quantum down to 0.5 mm
  double column_time_s = kNotMeasured;       ///< time from a column to that of the next higher azimuth
  // Which pixels return
  double points = kNotMeasured, return_rate = kNotMeasured, return_rate_min = kNotMeasured,
         return_rate_max = kNotMeasured;
  double blind_columns_share = kNotMeasured;
  double columns_never_seen = kNotMeasured, low_ring_columns_never_seen = kNotMeasured;  ///< over the set
  std::vector<double> ring_rate;                                                         ///< returns / columns
  std::vector<double> ring_never_seen;  ///< columns without a return in the whole set
  std::vector<double> ring_rate_seen;   ///< returns / pixels that return at least once in the set; mean over the set
  // Ranges
  std::vector<double> range_histogram, range_percentiles_m;
  std::vector<double> range_noise_m;
  // Edges and drop-outs
  double dropout = kNotMeasured;
  std::vector<double> dropout_by_range;
  std::vector<double> dropout_by_signal;  ///< pooled over the set
  double jump = kNotMeasured, mixed_pixels_per_jump = kNotMeasured, mixed_pixels = kNotMeasured;
  // The ground
  double ground_height_m = kNotMeasured, ground_share = kNotMeasured, ground_cells = kNotMeasured;
  double ground_plane_std_m = kNotMeasured, ground_plane_mad_m = kNotMeasured, ground_slope_deg = kNotMeasured;
  std::vector<double> ground_plane_std_quartiles_m;
  // Shape
  std::vector<double> spacing_m;
  double spacing_per_azimuth_step = kNotMeasured;
  double voxels = kNotMeasured, sparse_share = kNotMeasured;
  std::vector<double> linear_planar_scatter, planar_vertical_horizontal;
  double sc_occupancy = kNotMeasured, sc_height_m = kNotMeasured;
  std::vector<double> sc_ring_occupancy;
  std::vector<double> height_percentiles_m;

  void describe(ParamVisitor& visitor) override;
};

/// Walks the figures in order, `scans` left out: numbers to one function, lists to the other.
void visitFigures(RealismFigures& figures, const std::function<void(const std::string& key, double&)>& number,
                  const std::function<void(const std::string& key, std::vector<double>&)>& list);

/// One figure under its key: a number, or a list.
struct NamedFigure {
  std::string key;
  bool list = false;
  std::vector<double> values;
};
/// All figures in order, `scans` left out.
std::vector<NamedFigure> namedFigures(const RealismFigures& figures);

/// Each number the median of that number over the scans where it was measured.
RealismFigures medianOf(const std::vector<RealismFigures>& scans);

}  // namespace scslam::sim
