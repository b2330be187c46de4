// Order statistics as the figures use them: NaN stands for "not measured" and is never counted.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace scslam::sim {

inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

inline bool measured(double value) { return !std::isnan(value); }

/// Value below which `percent` of the values lie, linear between neighbours; kNotMeasured when there is none.
inline double percentile(std::vector<double> values, double percent) {
  std::erase_if(values, [](double v) { return !measured(v); });
  if (values.empty()) return kNotMeasured;
  const double place = percent / 100 * static_cast<double>(values.size() - 1);
  const auto below = values.begin() + static_cast<std::ptrdiff_t>(place);
  std::nth_element(values.begin(), below, values.end());
  const double lo = *below, t = place - std::floor(place);
  return t == 0 ? lo : lo + t * (*std::min_element(below + 1, values.end()) - lo);
}

inline double median(std::vector<double> values) { return percentile(std::move(values), 50); }

/// Standard deviation that outliers do not move: 1.4826 times the median distance from the median.
inline double robustDeviation(std::vector<double> values) {
  const double middle = median(values);
  for (double& v : values) v = std::abs(v - middle);
  return 1.4826 * median(std::move(values));
}

/// part / whole; kNotMeasured where there is no whole.
inline double share(double part, double whole) { return whole > 0 ? part / whole : kNotMeasured; }

}  // namespace scslam::sim
