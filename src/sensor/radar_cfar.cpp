#include "scslam/sensor/radar_cfar.h"

#include <algorithm>
#include <cmath>

namespace scslam {

LinearPower::LinearPower(double counts_per_db) {
  for (std::size_t level = 0; level < of_level_.size(); ++level)
    of_level_[level] = std::pow(10, static_cast<double>(level) / (10 * counts_per_db));
}

void CfarWindowParams::describeCfar(ParamVisitor& v) {
  v.field("window_m", window_m, "reference cells reach so far on each side of a peak [m]", 0.01, 1000);
  v.field("guard_m", guard_m, "cells this near to a peak are its own echo [m]", 0, 1000);
  v.field("counts_per_db", counts_per_db, "grey levels a decibel of received power", 0.01, 100);
  v.field("min_power", min_power, "weaker peaks are not tested [grey levels]", 1, 255);
  describeWindow(v);
}

CfarWindow::CfarWindow(const CfarWindowParams& params, const RadarScan& scan) : bins_(params.binsOf(scan)) {
  const auto bins = [&](double metres) {
    const double count = bins_.end > 0 ? metres / scan.range_resolution_m : 0;
    return static_cast<std::size_t>(std::clamp(std::round(count), 0.0, static_cast<double>(scan.bins)));
  };
  window_ = std::max<std::size_t>(1, bins(params.window_m));
  guard_ = bins(params.guard_m);
}

ReferenceCells CfarWindow::around(std::size_t bin) const {
  const auto atLeastBegin = [&](std::size_t reach) { return bin - std::min(reach, bin - bins_.begin); };
  ReferenceCells cells;
  cells.near_begin = atLeastBegin(guard_ + window_), cells.near_end = atLeastBegin(guard_);
  cells.far_begin = std::min(bins_.end, bin + 1 + guard_),
  cells.far_end = std::min(bins_.end, bin + 1 + guard_ + window_);
  return cells;
}

void prefixSums(std::span<const std::uint8_t> row, const LinearPower& linear, std::vector<double>& sums) {
  sums.resize(row.size() + 1);
  double sum = 0;
  sums[0] = 0;
  for (std::size_t i = 0; i < row.size(); ++i) sums[i + 1] = sum += linear(row[i]);
}

double meanPower(const ReferenceCells& cells, const std::vector<double>& sums) {
  const double sum = sums[cells.near_end] - sums[cells.near_begin] + sums[cells.far_end] - sums[cells.far_begin];
  return sum / static_cast<double>(cells.count());
}

double cellAveragingFactor(double false_alarm_rate, std::size_t n) {
  const auto cells = static_cast<double>(n);
  return cells * (std::pow(false_alarm_rate, -1 / cells) - 1);
}

double orderedStatisticFactor(double false_alarm_rate, std::size_t n, std::size_t k) {
  const auto rate = [&](double factor) {
    double product = 1;
    for (std::size_t i = 0; i < k; ++i) product *= static_cast<double>(n - i) / (static_cast<double>(n - i) + factor);
    return product;
  };
  double low = 0, high = 1;
  while (rate(high) > false_alarm_rate && high < 1e12) high *= 2;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (rate(middle) > false_alarm_rate ? low : high) = middle;
  }
  return high;
}

}  // namespace scslam
