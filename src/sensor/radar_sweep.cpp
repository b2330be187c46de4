#include "scslam/sensor/radar_sweep.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace scslam {
namespace {

constexpr double kTurn = 2 * M_PI;
constexpr double kLongestGap = 60;  // [s]

/// Clockwise from one angle to the next: 0 … 2 pi.
double advance(double from, double to) {
  const double turns = (to - from) / kTurn;
  return (turns - std::floor(turns)) * kTurn;
}

Stamp later(Stamp stamp, double seconds) {
  return stamp + std::chrono::round<Stamp::duration>(std::chrono::duration<double>(seconds));
}

/// Measured azimuths that time and encoder agree on.
std::vector<std::size_t> believable(const RadarScan& sweep) {
  std::vector<std::size_t> rows;
  const double least = 0.1 * kTurn / static_cast<double>(sweep.azimuths);  // a tenth of the nominal step
  for (std::size_t i = 0; i < sweep.azimuths; ++i) {
    if (sweep.valid[i] == 0 || !std::isfinite(sweep.angles[i])) continue;
    if (!rows.empty()) {
      const double seconds = secondsBetween(sweep.stamps[rows.back()], sweep.stamps[i]);
      const double step = advance(sweep.angles[rows.back()], sweep.angles[i]);
      if (seconds < 0 || seconds > kLongestGap || step < least || step > kTurn - least) continue;
    }
    rows.push_back(i);
  }
  return rows;
}

/// Stamps and angles of what was not measured: between two measured azimuths evenly, before the first and after the
/// last at the pace of the sweep.
class Filler {
 public:
  Filler(RadarScan& sweep, const std::vector<std::size_t>& rows) : sweep_(sweep), rows_(rows) {}
  void fill() {
    const std::size_t first = rows_.front(), last = rows_.back();
    const double pace = secondsBetween(sweep_.stamps[first], sweep_.stamps[last]) / static_cast<double>(last - first);
    const double turn = kTurn / static_cast<double>(sweep_.azimuths);
    for (std::size_t i = 0; i < first; ++i) place(i, first, pace, turn);
    for (std::size_t i = last + 1; i < sweep_.azimuths; ++i) place(i, last, pace, turn);
    for (std::size_t k = 1; k < rows_.size(); ++k) {
      const std::size_t a = rows_[k - 1], b = rows_[k];
      const auto steps = static_cast<double>(b - a);
      const double seconds = secondsBetween(sweep_.stamps[a], sweep_.stamps[b]) / steps,
                   angle = advance(sweep_.angles[a], sweep_.angles[b]) / steps;
      for (std::size_t i = a + 1; i < b; ++i) place(i, a, seconds, angle);
    }
  }

 private:
  void place(std::size_t i, std::size_t from, double seconds_a_row, double angle_a_row) {
    const double steps = static_cast<double>(i) - static_cast<double>(from);
    sweep_.stamps[i] = later(sweep_.stamps[from], steps * seconds_a_row);
    sweep_.angles[i] = advance(0, sweep_.angles[from] + steps * angle_a_row);
  }
  RadarScan& sweep_;
  const std::vector<std::size_t>& rows_;
};

}  // namespace

std::size_t mendSweep(RadarScan& sweep) {
  if (!sweep.consistent() || sweep.azimuths == 0) return sweep.azimuths;
  const std::vector<std::size_t> rows = believable(sweep);
  std::vector<std::uint8_t> valid(sweep.azimuths, 0);
  if (rows.size() > 1) {  // one azimuth is no sweep; its stamp is still the best there is
    for (const std::size_t i : rows) valid[i] = sweep.valid[i];
    Filler(sweep, rows).fill();
  }
  sweep.valid = std::move(valid);
  return sweep.azimuths - (rows.size() > 1 ? rows.size() : 0);
}

void evenStamps(RadarScan& sweep) {
  if (!sweep.consistent()) return;
  double n = 0, x = 0, xx = 0, t = 0, xt = 0;
  for (std::size_t i = 0; i < sweep.azimuths; ++i) {
    if (sweep.valid[i] == 0) continue;
    const auto row = static_cast<double>(i);
    const double seconds = secondsBetween(sweep.stamps.front(), sweep.stamps[i]);
    n += 1, x += row, xx += row * row, t += seconds, xt += row * seconds;
  }
  const double determinant = n * xx - x * x;
  if (!(determinant > 0)) return;
  const double pace = (n * xt - x * t) / determinant, first = (t - pace * x) / n;
  const double most = 0.1 * pace * static_cast<double>(sweep.azimuths);
  std::vector<Stamp> even;
  for (std::size_t i = 0; i < sweep.azimuths; ++i) {
    const double seconds = first + pace * static_cast<double>(i);
    if (std::abs(seconds - secondsBetween(sweep.stamps.front(), sweep.stamps[i])) > most) return;
    even.push_back(later(sweep.stamps.front(), seconds));
  }
  sweep.stamps = std::move(even);
}

Scan scanOfSweep(RadarScan sweep) {
  mendSweep(sweep);
  evenStamps(sweep);
  Scan scan;
  if (!sweep.stamps.empty()) scan.stamp = sweep.stamps.front();
  scan.T_base_sensor = sweep.T_base_sensor;
  scan.planar = true;
  scan.label = sweep.label;
  scan.radar = std::make_shared<const RadarScan>(std::move(sweep));
  return scan;
}

}  // namespace scslam
