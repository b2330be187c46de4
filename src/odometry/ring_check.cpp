#include "scslam/odometry/ring_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace scslam {
namespace {

constexpr std::size_t kEnough = 20;  // points of a ring to judge by

/// Mean elevation [rad] of each ring that has enough points, ascending.
std::vector<double> elevationsOf(const ScanRings& rings, const std::vector<float>& slope) {
  std::vector<double> elevations;
  for (std::size_t r = 0; r < rings.count(); ++r) {
    if (rings.size(r) < kEnough) continue;
    double sum = 0;
    for (std::size_t k = 0; k < rings.size(r); ++k) sum += std::atan(static_cast<double>(slope[rings.ring(r)[k]]));
    elevations.push_back(sum / static_cast<double>(rings.size(r)));
  }
  std::sort(elevations.begin(), elevations.end());
  return elevations;
}

/// Share of the neighbours along a ring between whose elevations there is room for a ring.
double shareOfJumps(const ScanRings& rings, const std::vector<float>& slope, double spacing_rad) {
  std::size_t jumps = 0, pairs = 0;
  for (std::size_t r = 0; r < rings.count(); ++r) {
    for (std::size_t k = 1; k < rings.size(r); ++k) {
      const double a = std::atan(static_cast<double>(slope[rings.ring(r)[k - 1]]));
      const double b = std::atan(static_cast<double>(slope[rings.ring(r)[k]]));
      ++pairs;
      jumps += std::abs(a - b) > 1.5 * spacing_rad;
    }
  }
  return pairs > 0 ? static_cast<double>(jumps) / static_cast<double>(pairs) : 0.0;
}

}  // namespace

std::string doubtAboutRings(const ScanRings& rings, const std::vector<float>& slope) {
  const std::vector<double> elevations = elevationsOf(rings, slope);
  const std::size_t n = elevations.size();
  if (n < 4) return "";
  const auto [low, high] = std::minmax_element(slope.begin(), slope.end());
  const double span = std::atan(static_cast<double>(*high)) - std::atan(static_cast<double>(*low));
  const double spacing = span / static_cast<double>(n - 1);
  if (shareOfJumps(rings, slope, spacing) > 0.25)
    return fmt::format(
        "points that follow each other along its {} rings jump in elevation: the sensor has another number of rings "
        "(wrong sensor table?)",
        rings.count());
  std::size_t twins = 0;
  for (std::size_t r = 1; r < n; ++r) twins += elevations[r] - elevations[r - 1] < 0.1 * spacing;
  if (4 * twins >= n)
    return fmt::format(
        "{} of its {} rings lie at the elevation of another: the sensor has fewer rings (wrong sensor "
        "table?)",
        twins, n);
  return "";
}

std::string doubtAboutBeams(const std::vector<float>& levels, const std::vector<float>& slope) {
  if (levels.size() < 2 || slope.empty()) return "";
  double off = 0;
  std::vector<std::size_t> hits(levels.size());
  for (const float s : slope) {
    const auto above = std::upper_bound(levels.begin(), levels.end(), s);
    const auto i =
        std::clamp<std::ptrdiff_t>(above - levels.begin(), 1, static_cast<std::ptrdiff_t>(levels.size()) - 1);
    const double low = levels[static_cast<std::size_t>(i - 1)], high = levels[static_cast<std::size_t>(i)];
    const double to_low = std::abs(static_cast<double>(s) - low), to_high = std::abs(static_cast<double>(s) - high);
    ++hits[static_cast<std::size_t>(to_low < to_high ? i - 1 : i)];
    if (high > low) off += std::min(0.5, std::min(to_low, to_high) / (high - low));
  }
  // Anywhere between two beams is a quarter of the way off in the mean.
  if (off > 0.2 * static_cast<double>(slope.size()))
    return fmt::format("its points do not lie on the {} elevations that were given (wrong sensor table?)",
                       levels.size());
  const auto seen = [](std::size_t n) { return n >= kEnough; };
  const auto first = std::find_if(hits.begin(), hits.end(), seen);
  const auto last = std::find_if(hits.rbegin(), hits.rend(), seen).base();
  if (first >= last) return "";
  const auto between = last - first, used = std::count_if(first, last, seen);
  if (3 * (between - used) > between)
    return fmt::format(
        "of the {} elevations that were given only {} have points, with gaps between: the sensor has "
        "fewer rings (wrong sensor table?)",
        levels.size(), used);
  return "";
}

}  // namespace scslam
