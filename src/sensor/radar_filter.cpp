#include "scslam/sensor/radar_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace scslam {
namespace {

constexpr std::size_t kMedianStep = 4;  // every fourth bin tells the median

/// The points of a cloud by azimuth: ranges rise within each.
class ByAzimuth {
 public:
  ByAzimuth(const Cloud& cloud, std::size_t azimuths) : begin_(azimuths + 1, 0), range_(cloud.size()) {
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      ++begin_[cloud.ring[i] + std::size_t{1}];
      range_[i] = std::hypot(cloud.x[i], cloud.y[i]);
    }
    for (std::size_t a = 0; a < azimuths; ++a) begin_[a + 1] += begin_[a];
  }
  std::size_t begin(std::size_t azimuth) const { return begin_[azimuth]; }
  std::size_t end(std::size_t azimuth) const { return begin_[azimuth + 1]; }
  float range(std::size_t point) const { return range_[point]; }

  bool has(std::size_t azimuth, float from, float to) const {
    const auto first = range_.begin() + static_cast<std::ptrdiff_t>(begin(azimuth)),
               last = range_.begin() + static_cast<std::ptrdiff_t>(end(azimuth));
    const auto found = std::lower_bound(first, last, from);
    return found != last && *found <= to;
  }

 private:
  std::vector<std::size_t> begin_;
  std::vector<float> range_;
};

int medianOf(std::span<const std::uint8_t> row) {
  std::array<std::size_t, 256> count{};
  std::size_t n = 0;
  for (std::size_t i = 0; i < row.size(); i += kMedianStep) ++count[row[i]], ++n;
  std::size_t below = 0;
  for (std::size_t level = 0; level < count.size(); ++level)
    if ((below += count[level]) > n / 2) return static_cast<int>(level);
  return 0;
}

/// Median power of each azimuth; -1 where it was not measured.
std::vector<int> mediansOf(const RadarScan& scan) {
  std::vector<int> medians(scan.azimuths, -1);
  for (std::size_t a = 0; a < scan.azimuths; ++a)
    if (scan.valid[a] != 0) medians[a] = medianOf(scan.row(a));
  return medians;
}

int typicalOf(const std::vector<int>& medians) {
  std::vector<int> measured;
  std::copy_if(medians.begin(), medians.end(), std::back_inserter(measured), [](int m) { return m >= 0; });
  if (measured.empty()) return 0;
  const auto middle = measured.begin() + static_cast<std::ptrdiff_t>(measured.size() / 2);
  std::nth_element(measured.begin(), middle, measured.end());
  return *middle;
}

void markStreaks(const Cloud& cloud, const RadarScan& scan, const ByAzimuth& rows, const RadarFilterParams& params,
                 std::vector<std::uint8_t>& keep, RadarFilterReport& report) {
  const std::vector<int> medians = mediansOf(scan);
  const double typical = typicalOf(medians);
  for (std::size_t a = 0; a < scan.azimuths; ++a) {
    const bool blind = medians[a] > params.most_median;
    if (!blind && medians[a] <= typical + params.streak_rise) continue;
    ++report.raised_azimuths;
    for (std::size_t i = rows.begin(a); i < rows.end(a); ++i)
      if (blind || static_cast<double>(cloud.intensity[i]) < medians[a] + params.streak_contrast)
        keep[i] = 0, ++report.streaks;
  }
}

void markMultipath(const Cloud& cloud, const ByAzimuth& rows, std::size_t azimuths, const RadarFilterParams& params,
                   std::vector<std::uint8_t>& keep, RadarFilterReport& report) {
  const auto isGhost = [&](std::size_t i, std::size_t first) {
    for (std::size_t k = first; k < i; ++k) {
      if (static_cast<double>(cloud.intensity[k] - cloud.intensity[i]) < params.multipath_drop) continue;
      for (int m = 2; m <= params.multipath_order; ++m)
        if (std::abs(static_cast<double>(rows.range(i) - static_cast<float>(m) * rows.range(k))) <
            params.multipath_tolerance_m)
          return true;
    }
    return false;
  };
  for (std::size_t a = 0; a < azimuths; ++a)
    for (std::size_t i = rows.begin(a); i < rows.end(a); ++i)
      if (keep[i] != 0 && isGhost(i, rows.begin(a))) keep[i] = 0, ++report.multipath;
}

void markSpeckle(const ByAzimuth& rows, std::size_t azimuths, const RadarFilterParams& params,
                 std::vector<std::uint8_t>& keep, RadarFilterReport& report) {
  const auto reach = static_cast<float>(params.speckle_range_m);
  for (std::size_t a = 0; a < azimuths; ++a) {
    for (std::size_t i = rows.begin(a); i < rows.end(a); ++i) {
      if (keep[i] == 0) continue;
      int company = 0;
      for (const std::size_t step : {std::size_t{1}, std::size_t{2}})
        for (const std::size_t other : {(a + step) % azimuths, (a + azimuths - step % azimuths) % azimuths})
          company += other != a && rows.has(other, rows.range(i) - reach, rows.range(i) + reach);
      if (company < params.speckle_neighbours) keep[i] = 0, ++report.speckle;
    }
  }
}

}  // namespace

void RadarFilterParams::describe(ParamVisitor& v) {
  v.field("enabled", enabled, "remove what is not there");
  v.field("streak_rise", streak_rise,
          "an azimuth whose median is so far above the median one's has a streak [grey levels]", 0, 255);
  v.field("streak_contrast", streak_contrast, "what must stand out of a streak [grey levels]", 0, 255);
  v.field("most_median", most_median, "an azimuth with a higher median shows nothing [grey levels]", 1, 255);
  v.field("multipath_order", multipath_order, "ghosts are looked for up to this multiple of a range; 1: not at all", 1,
          10);
  v.field("multipath_drop", multipath_drop, "a ghost is so much weaker than what it is a ghost of [grey levels]", 0,
          255);
  v.field("multipath_tolerance_m", multipath_tolerance_m, "and so near to the multiple [m]", 0, 10);
  v.field("speckle_neighbours", speckle_neighbours,
          "of the four azimuths around, so many must show it too; 0: any point stays", 0, 4);
  v.field("speckle_range_m", speckle_range_m, "within this range of it [m]", 0.01, 100);
}

RadarFilterReport filterRadarPoints(Cloud& cloud, const RadarScan& scan, const RadarFilterParams& params) {
  RadarFilterReport report;
  if (!params.enabled || cloud.empty() || !scan.consistent()) return report;
  const ByAzimuth rows(cloud, scan.azimuths);
  std::vector<std::uint8_t> keep(cloud.size(), 1);
  markStreaks(cloud, scan, rows, params, keep, report);
  markMultipath(cloud, rows, scan.azimuths, params, keep, report);
  if (params.speckle_neighbours > 0) markSpeckle(rows, scan.azimuths, params, keep, report);
  if (report.removed() != 0) cloud.filter(keep);
  return report;
}

}  // namespace scslam
