#include "sim/realism_score.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <numbers>

namespace scslam::sim {
namespace {

constexpr int kLeastScansForRings = 5;
constexpr double kLeastOnRing = 0.95;

double clamped(double value) { return std::clamp(value, 0.0, 1.0); }

/// |ln(a / b)|: 0 for two zeros, infinite for one.
double logRatio(double a, double b) { return a == b ? 0 : std::abs(std::log(a / b)); }

/// Indices where both lists have a measured number.
std::vector<std::size_t> shared(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<std::size_t> both;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    if (measured(a[i]) && measured(b[i])) both.push_back(i);
  return both;
}

/// Half the L1 distance of two lists; NaN when a number is missing.
double halfL1(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.empty() || a.size() != b.size()) return kNotMeasured;
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum / 2;
}

/// Collects what was checked of the grid.
struct GridChecks {
  int right = 0, wrong = 0;
  std::vector<std::string> words;

  void leaveOut(const std::string& what, const std::string& why) {
    words.push_back(fmt::format("{} left out ({})", what, why));
  }
  void judge(bool ok, const std::string& finding) {
    ++(ok ? right : wrong);
    words.push_back((ok ? "" : "WRONG: ") + finding);
  }
};

void checkElevation(const RealismFigures& f, const GridTolerance& tolerance, GridChecks& checks) {
  if (tolerance.elevation_deg == 0) return checks.leaveOut("elevation", "not exact in the real set");
  if (!measured(f.elevation_off_deg)) return checks.leaveOut("elevation", "the table has none");
  checks.judge(f.elevation_off_deg <= tolerance.elevation_deg && f.on_ring_share >= kLeastOnRing,
               fmt::format("elevation off by {:.3f} deg (limit {}), {:.1f} % on rings", f.elevation_off_deg,
                           tolerance.elevation_deg, 100 * f.on_ring_share));
}

void checkAzimuth(const RealismFigures& f, const GridTolerance& tolerance, GridChecks& checks) {
  if (tolerance.azimuth_step == 0) return checks.leaveOut("azimuth", "not exact in the real set");
  if (!measured(f.azimuth_off_step) || !measured(f.azimuth_drift_step))
    return checks.leaveOut("azimuth", "too few returns a ring");
  checks.judge(std::max(f.azimuth_off_step, f.azimuth_drift_step) <= tolerance.azimuth_step,
               fmt::format("azimuth off its grid by {:.3f}, phase drift {:.3f} steps (limit {})", f.azimuth_off_step,
                           f.azimuth_drift_step, tolerance.azimuth_step));
}

void checkQuantum(const RealismFigures& f, const GridTolerance& tolerance, GridChecks& checks) {
  if (tolerance.range_quantum_m == 0) return checks.leaveOut("range quantum", "not to be seen in the real set");
  if (!measured(f.range_quantum_m)) return checks.leaveOut("range quantum", "no returns");
  checks.judge(std::abs(f.range_quantum_m - tolerance.range_quantum_m) < 1e-9,
               fmt::format("range quantum {} mm of {} mm", 1000 * f.range_quantum_m, 1000 * tolerance.range_quantum_m));
}

void checkColumnTime(const RealismFigures& f, const SensorModel& table, const GridTolerance& tolerance,
                     GridChecks& checks) {
  if (tolerance.column_time == 0) return checks.leaveOut("column time", "unchecked");
  if (!measured(f.column_time_s)) return checks.leaveOut("column time", "the points carry no time");
  const double expected = (table.clockwise ? -1 : 1) * table.sweep_s / table.columns;
  checks.judge(std::abs(f.column_time_s - expected) <= tolerance.column_time * std::abs(expected),
               fmt::format("column time {:.2f} us of {:.2f} us", 1e6 * f.column_time_s, 1e6 * expected));
}

Score gridScore(const RealismFigures& f, const SensorModel& table, const RealismTarget& target) {
  GridChecks checks;
  checkElevation(f, target.grid, checks);
  checkAzimuth(f, target.grid, checks);
  checkQuantum(f, target.grid, checks);
  checkColumnTime(f, table, target.grid, checks);
  Score score{"grid", std::nullopt, 1, fmt::format("{}", fmt::join(checks.words, "; "))};
  if (checks.right + checks.wrong > 0) score.value = checks.wrong == 0 ? 1 : 0;
  return score;
}

Score noiseScore(const RealismFigures& f, const RealismTarget& target) {
  const auto& real = target.figures.range_noise_m;
  const auto bins = shared(f.range_noise_m, real);
  Score score{"noise", std::nullopt, 0.8, "no range bin is measured on both sides"};
  if (bins.empty()) return score;
  const auto off = [&](std::size_t i) { return logRatio(f.range_noise_m[i], real[i]); };
  const std::size_t worst =
      *std::max_element(bins.begin(), bins.end(), [&](auto a, auto b) { return off(a) < off(b); });
  score.value = clamped(1 - off(worst) / std::numbers::ln2);
  score.note = fmt::format("{} bins; worst {}-{} m: {:.2f} cm against {:.2f} cm", bins.size(), kNoiseBins_m[worst],
                           kNoiseBins_m[worst + 1], 100 * f.range_noise_m[worst], 100 * real[worst]);
  return score;
}

Score dropoutScore(const RealismFigures& f, const RealismTarget& target) {
  double sum = 0;
  const auto add = [&sum](const std::vector<double>& rates, const std::vector<double>& real) {
    const auto bins = shared(rates, real);
    for (const std::size_t i : bins) sum += std::min(1.0, logRatio(rates[i], real[i]) / std::numbers::ln10);
    return bins.size();
  };
  const std::size_t by_range = add(f.dropout_by_range, target.figures.dropout_by_range);
  const std::size_t by_signal = add(f.dropout_by_signal, target.figures.dropout_by_signal);
  Score score{"drop-out", std::nullopt, 0.7, fmt::format("{} bins by range, {} by signal", by_range, by_signal)};
  if (target.figures.dropout_by_signal.empty())
    score.note += " (the real set has no signal)";
  else if (f.dropout_by_signal.empty())
    score.note += " (these scans have no signal)";
  if (by_range + by_signal > 0) score.value = clamped(1 - sum / static_cast<double>(by_range + by_signal));
  return score;
}

Score ringScore(const RealismFigures& f, const RealismTarget& target) {
  const auto& rate = f.ring_rate_seen;
  const auto& real = target.figures.ring_rate_seen;
  Score score{"ring occupancy", std::nullopt, 0.9, ""};
  if (rate.size() != real.size()) {
    score.note = fmt::format("{} rings cannot be compared with {}", rate.size(), real.size());
  } else if (f.scans < kLeastScansForRings) {
    score.note = fmt::format("from {} scans one cannot tell which pixels are blind; {} are needed", f.scans,
                             kLeastScansForRings);
  } else if (const auto rings = shared(rate, real); !rings.empty()) {
    double sum = 0;
    for (const std::size_t i : rings) sum += (rate[i] - real[i]) * (rate[i] - real[i]);
    const double rmse = std::sqrt(sum / static_cast<double>(rings.size()));
    score.value = clamped(1 - rmse);
    score.note = fmt::format("RMS difference {:.3f} over {} rings", rmse, rings.size());
  } else {
    score.note = "no ring is measured on both sides";
  }
  return score;
}

/// Jensen-Shannon divergence in bits, 0 for equal and 1 for disjoint histograms.
double divergence(const std::vector<double>& p, const std::vector<double>& q) {
  double sum = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double middle = (p[i] + q[i]) / 2;
    if (p[i] > 0) sum += p[i] / 2 * std::log2(p[i] / middle);
    if (q[i] > 0) sum += q[i] / 2 * std::log2(q[i] / middle);
  }
  return sum;
}

Score rangeScore(const RealismFigures& f, const RealismTarget& target, const std::vector<RealismTarget>& real_sets) {
  Score score{"range histogram", std::nullopt, 0.9, "no histogram on both sides"};
  const auto compare = [&](const RealismTarget& set) {
    if (f.range_histogram.empty() ||
        shared(f.range_histogram, set.figures.range_histogram).size() != f.range_histogram.size())
      return;
    const double value = clamped(1 - divergence(f.range_histogram, set.figures.range_histogram));
    if (score.value && *score.value >= value) return;
    score.value = value;
    score.note = "nearest real set: " + set.name;
  };
  compare(target);
  for (const RealismTarget& set : real_sets) compare(set);
  return score;
}

Score geometryScore(const RealismFigures& f, const RealismTarget& target) {
  const RealismFigures& real = target.figures;
  const double shape = halfL1(f.linear_planar_scatter, real.linear_planar_scatter);
  const double edges = halfL1({f.jump, f.mixed_pixels_per_jump}, {real.jump, real.mixed_pixels_per_jump});
  Score score{"local geometry", std::nullopt, 0.7, ""};
  const auto text = [](double d) { return measured(d) ? fmt::format("{:.3f}", d) : "(not measured)"; };
  score.note = fmt::format("linear/planar/scatter apart by {}, jumps and mixed pixels by {}", text(shape), text(edges));
  if (const double larger = std::fmax(shape, edges); measured(larger)) score.value = clamped(1 - larger);
  return score;
}

}  // namespace

std::vector<Score> scoreRealism(const RealismFigures& figures, const SensorModel& table, const RealismTarget& target,
                                const std::vector<RealismTarget>& real_sets) {
  return {gridScore(figures, table, target),      noiseScore(figures, target),
          dropoutScore(figures, target),          ringScore(figures, target),
          rangeScore(figures, target, real_sets), geometryScore(figures, target)};
}

}  // namespace scslam::sim
