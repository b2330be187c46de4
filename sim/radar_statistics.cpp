#include "sim/radar_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace scslam::sim {

namespace {

using Rows = std::vector<std::span<const std::uint8_t>>;

/// Pearson's coefficient, gathered pair by pair.
class Correlation {
 public:
  void add(double a, double b) { n_ += 1, a_ += a, b_ += b, aa_ += a * a, bb_ += b * b, ab_ += a * b; }
  double value() const {
    if (n_ == 0) return 0;
    const double va = aa_ - a_ * a_ / n_, vb = bb_ - b_ * b_ / n_;
    return va > 0 && vb > 0 ? (ab_ - a_ * b_ / n_) / std::sqrt(va * vb) : 0;
  }

 private:
  double n_ = 0, a_ = 0, b_ = 0, aa_ = 0, bb_ = 0, ab_ = 0;
};

/// Counts of the 256 grey levels.
struct Histogram {
  std::array<double, 256> counts{};
  double total = 0;
  void add(std::span<const std::uint8_t> values) {
    for (const std::uint8_t v : values) ++counts[v];
    total += static_cast<double>(values.size());
  }
  double mean() const {
    double sum = 0;
    for (std::size_t v = 0; v < 256; ++v) sum += counts[v] * static_cast<double>(v);
    return total > 0 ? sum / total : 0;
  }
  double sigma() const {
    double sum = 0;
    const double m = mean();
    for (std::size_t v = 0; v < 256; ++v) sum += counts[v] * std::pow(static_cast<double>(v) - m, 2);
    return total > 0 ? std::sqrt(sum / total) : 0;
  }
  double percentile(double percent) const {
    double sum = 0;
    for (std::size_t v = 0; v < 256; ++v)
      if (sum += counts[v]; sum >= total * percent / 100) return static_cast<double>(v);
    return 255;
  }
  double share(std::size_t value) const { return total > 0 ? counts[value] / total : 0; }
};

double acrossRows(const Rows& rows, std::size_t first_bin) {
  Correlation c;
  for (std::size_t i = 0; i + 1 < rows.size(); ++i)
    for (std::size_t k = first_bin; k < rows[i].size(); ++k) c.add(rows[i][k], rows[i + 1][k]);
  return c.value();
}

std::array<double, 3> alongRange(const Rows& rows, std::size_t first_bin) {
  std::array<double, 3> result{};
  for (std::size_t which = 0; which < 3; ++which) {
    const std::size_t lag = std::size_t{1} << which;
    Correlation c;
    for (const auto& row : rows)
      for (std::size_t k = first_bin; k + lag < row.size(); ++k) c.add(row[k], row[k + lag]);
    result[which] = c.value();
  }
  return result;
}

}  // namespace

RadarStatistics statisticsOf(const RadarScan& scan) {
  RadarStatistics s;
  Rows rows;
  for (std::size_t i = 0; i < scan.azimuths; ++i)
    if (scan.valid[i] != 0) rows.push_back(scan.row(i));
  if (rows.empty() || scan.bins == 0) return s;
  const std::size_t quiet_from = scan.bins - scan.bins / 4;
  Histogram all, quiet;
  for (const auto& row : rows) all.add(row), quiet.add(row.subspan(quiet_from));
  s.zeros = all.share(0), s.saturated = all.share(255);
  s.quiet_mean = quiet.mean(), s.quiet_sigma = quiet.sigma(), s.quiet_p99 = quiet.percentile(99);
  for (std::size_t i = 0; i < s.percentiles.size(); ++i) s.percentiles[i] = all.percentile(s.kPercents[i]);
  s.azimuth_correlation = acrossRows(rows, 0), s.quiet_azimuth_correlation = acrossRows(rows, quiet_from);
  s.range_correlation = alongRange(rows, 0), s.quiet_range_correlation = alongRange(rows, quiet_from);
  const double threshold = s.quiet_mean + 3 * s.quiet_sigma + 20, n = static_cast<double>(rows.size());
  for (const auto& row : rows) {
    const auto above = static_cast<double>(
        std::count_if(row.begin(), row.end(), [&](std::uint8_t v) { return static_cast<double>(v) > threshold; }));
    s.strong += std::min(above, 12.0) / n, s.strong_all += above / n;
    for (std::size_t e = 0; e < 8; ++e) {
      Histogram part;
      part.add(row.subspan(scan.bins * e / 8, scan.bins * (e + 1) / 8 - scan.bins * e / 8));
      s.profile[e] += part.mean() / n;
    }
  }
  return s;
}

std::string compareStatistics(const std::string& name_a, const RadarStatistics& a, const std::string& name_b,
                              const RadarStatistics& b) {
  std::string text = fmt::format("{:<34} {:>12} {:>12}\n", "", name_a, name_b);
  const auto line = [&](const std::string& what, double x, double y) {
    text += fmt::format("{:<34} {:>12.3f} {:>12.3f}\n", what, x, y);
  };
  line("share of exact zeros", a.zeros, b.zeros);
  line("quiet area: mean", a.quiet_mean, b.quiet_mean);
  line("quiet area: sigma", a.quiet_sigma, b.quiet_sigma);
  line("quiet area: 99th percentile", a.quiet_p99, b.quiet_p99);
  line("correlation of rows", a.azimuth_correlation, b.azimuth_correlation);
  line("quiet area: correlation of rows", a.quiet_azimuth_correlation, b.quiet_azimuth_correlation);
  for (std::size_t i = 0; i < 3; ++i)
    line(fmt::format("correlation {} bins apart", 1 << i), a.range_correlation[i], b.range_correlation[i]);
  for (std::size_t i = 0; i < 3; ++i)
    line(fmt::format("quiet area: {} bins apart", 1 << i), a.quiet_range_correlation[i], b.quiet_range_correlation[i]);
  line("strongest above threshold (<= 12)", a.strong, b.strong);
  line("all above threshold", a.strong_all, b.strong_all);
  line("share of 255", a.saturated, b.saturated);
  for (std::size_t i = 0; i < a.percentiles.size(); ++i)
    line(fmt::format("percentile {:.0f}", RadarStatistics::kPercents[i]), a.percentiles[i], b.percentiles[i]);
  for (std::size_t e = 0; e < 8; ++e) line(fmt::format("mean of range eighth {}", e + 1), a.profile[e], b.profile[e]);
  return text;
}

}  // namespace scslam::sim
