#include "sim/image_figures.h"

#include <algorithm>

namespace scslam::sim {
namespace {

constexpr std::size_t kLeastNoiseSamples = 200;
constexpr double kLevelPoints = 0.95;  ///< share of the ranges that must lie on a quantum

/// Calls visit(ring, column, range before, range, range after) for every pixel, columns wrapping around.
template <class Visit>
void forPixels(const RangeImage& image, Visit&& visit) {
  for (int ring = 0; ring < image.rings; ++ring)
    for (int column = 0; column < image.columns; ++column)
      visit(ring, column, image.at(ring, column - 1), image.at(ring, column), image.at(ring, column + 1));
}

/// Both neighbours return, at ranges so near to each other that something between them should return too.
bool neighboursAgree(double before, double after) {
  return std::abs(before - after) < 0.05 + 0.02 * std::min(before, after);  // false for NaN
}

std::vector<double> rangesOf(const RangeImage& image) {
  std::vector<double> ranges;
  for (const double r : image.range_m)
    if (measured(r)) ranges.push_back(r);
  return ranges;
}

/// The coarsest of some usual steps that the ranges are multiples of, within a tenth of it; 0 when there is none.
double quantumOf(const std::vector<double>& ranges) {
  for (const double quantum : {0.1, 0.05, 0.02, 0.01, 0.005, 0.004, 0.003, 0.002, 0.001, 0.0005}) {
    const auto on = std::count_if(ranges.begin(), ranges.end(), [quantum](double r) {
      const double steps = r / quantum;
      return std::abs(steps - std::nearbyint(steps)) < 0.1;
    });
    if (static_cast<double>(on) >= kLevelPoints * static_cast<double>(ranges.size())) return quantum;
  }
  return 0;
}

double intensityAt(const RangeImage& image, const Cloud& cloud, int ring, int column) {
  const int wrapped = (column + image.columns) % image.columns;
  return cloud.intensity[static_cast<std::size_t>(image.point[image.pixel(ring, wrapped)])];
}

}  // namespace

void measureReturns(const RangeImage& image, RealismFigures& f) {
  const std::vector<double> ranges = rangesOf(image);
  const auto n = static_cast<double>(ranges.size());
  f.points = n;
  f.return_rate = f.return_rate_min = f.return_rate_max = share(n, static_cast<double>(image.range_m.size()));
  std::vector<double> column_returns(static_cast<std::size_t>(image.columns), 0.0);
  f.ring_rate.assign(static_cast<std::size_t>(image.rings), 0.0);
  f.range_histogram.assign(kRangeHistogram_m.size(), 0.0);
  for (int ring = 0; ring < image.rings; ++ring)
    for (int column = 0; column < image.columns; ++column)
      if (image.returned(ring, column)) {
        f.ring_rate[static_cast<std::size_t>(ring)] += 1.0 / image.columns;
        column_returns[static_cast<std::size_t>(column)] += 1;
      }
  f.blind_columns_share =
      static_cast<double>(std::count(column_returns.begin(), column_returns.end(), 0.0)) / image.columns;
  for (const double r : ranges) {
    const auto above = std::upper_bound(kRangeHistogram_m.begin(), kRangeHistogram_m.end(), r);
    f.range_histogram[static_cast<std::size_t>(above - kRangeHistogram_m.begin()) - 1] += 1 / n;
  }
  for (const double percent : {5, 25, 50, 75, 95}) f.range_percentiles_m.push_back(percentile(ranges, percent));
}

void measureDropouts(const RangeImage& image, RealismFigures& f, RangeCounts& pooled) {
  DropoutCount all;
  RangeCounts by_range{};
  forPixels(image, [&](int, int, double before, double range, double after) {
    if (!neighboursAgree(before, after)) return;
    const double lost = measured(range) ? 0 : 1;
    all.pixels += 1, all.lost += lost;
    const int bin = binOf(kDropoutBins_m, before);
    if (bin < 0) return;
    by_range[static_cast<std::size_t>(bin)].pixels += 1, by_range[static_cast<std::size_t>(bin)].lost += lost;
  });
  f.dropout = share(all.lost, all.pixels);
  for (std::size_t bin = 0; bin < by_range.size(); ++bin) {
    f.dropout_by_range.push_back(share(by_range[bin].lost, by_range[bin].pixels));
    pooled[bin].pixels += by_range[bin].pixels, pooled[bin].lost += by_range[bin].lost;
  }
}

void measureEdges(const RangeImage& image, RealismFigures& f) {
  double pairs = 0, jumps = 0, edges = 0, mixed = 0, returns = 0;
  forPixels(image, [&](int, int, double before, double range, double after) {
    if (!measured(range)) return;
    returns += 1;
    if (!measured(before)) return;
    pairs += 1, jumps += std::abs(range - before) > 0.5 ? 1 : 0;
    const double lo = std::min(before, after), hi = std::max(before, after);
    if (!measured(after) || hi - lo <= 1.0) return;
    edges += 1, mixed += range - lo > 0.3 && hi - range > 0.3 ? 1 : 0;
  });
  f.jump = share(jumps, pairs);
  f.mixed_pixels_per_jump = share(mixed, edges);
  f.mixed_pixels = share(mixed, returns);
}

void measureNoise(const RangeImage& image, RealismFigures& f) {
  std::array<std::vector<double>, kNoiseBins_m.size() - 1> samples;
  for (int ring = 0; ring < image.rings; ++ring)
    for (int column = 0; column < image.columns; ++column) {
      std::array<double, 5> r;
      for (int k = 0; k < 5; ++k) r[static_cast<std::size_t>(k)] = image.at(ring, column + k - 2);
      const double difference = r[0] - 4 * r[1] + 6 * r[2] - 4 * r[3] + r[4];
      if (!measured(difference)) continue;
      const auto [lo, hi] = std::minmax_element(r.begin(), r.end());
      const int bin = binOf(kNoiseBins_m, r[2]);
      if (*hi - *lo < 0.25 && bin >= 0) samples[static_cast<std::size_t>(bin)].push_back(std::abs(difference));
    }
  for (auto& bin : samples)
    f.range_noise_m.push_back(bin.size() > kLeastNoiseSamples ? 1.4826 * median(std::move(bin)) / std::sqrt(70.0)
                                                              : kNotMeasured);
}

void measureGrid(const RangeImage& image, const Cloud& cloud, RealismFigures& f) {
  f.on_ring_share = share(static_cast<double>(image.on_ring), static_cast<double>(image.offered));
  f.azimuth_off_step = image.azimuth_off_step;
  f.range_quantum_m = quantumOf(rangesOf(image));
  if (!cloud.hasTime()) return;
  std::vector<double> steps;
  for (int ring = 0; ring < image.rings; ++ring)
    for (int column = 0; column + 1 < image.columns; ++column) {
      if (!image.returned(ring, column) || !image.returned(ring, column + 1)) continue;
      const auto a = static_cast<std::size_t>(image.point[image.pixel(ring, column)]);
      const auto b = static_cast<std::size_t>(image.point[image.pixel(ring, column + 1)]);
      steps.push_back(static_cast<double>(cloud.dt[b]) - static_cast<double>(cloud.dt[a]));
    }
  f.column_time_s = median(std::move(steps));
}

std::string whyNoSignal(const RangeImage& image, const Cloud& cloud) {
  if (!cloud.hasIntensity()) return "the points have no intensity";
  std::vector<double> all, from_ring_median;
  for (int ring = 0; ring < image.rings; ++ring) {
    std::vector<double> row;
    for (int column = 0; column < image.columns; ++column)
      if (image.returned(ring, column)) row.push_back(intensityAt(image, cloud, ring, column));
    const double middle = median(row);
    for (const double value : row) all.push_back(value), from_ring_median.push_back(std::abs(value - middle));
  }
  const auto [lo, hi] = std::minmax_element(all.begin(), all.end());
  if (all.empty() || *lo == *hi) return "all intensities are equal";
  if (*hi <= 1) return "the intensity runs from 0 to 1 and is not in counts";
  if (1.4826 * median(std::move(from_ring_median)) < 0.05 * robustDeviation(std::move(all)))
    return "the intensity only tells the ring (A-LOAM writes ring and time there)";
  return "";
}

void countBySignal(const RangeImage& image, const Cloud& cloud, SignalCounts& counts) {
  forPixels(image, [&](int ring, int column, double before, double range, double after) {
    if (!neighboursAgree(before, after)) return;
    const double signal =
        (intensityAt(image, cloud, ring, column - 1) + intensityAt(image, cloud, ring, column + 1)) / 2;
    const int bin = binOf(kSignalBins, signal);
    if (bin < 0) return;
    DropoutCount& count = counts[static_cast<std::size_t>(bin)];
    count.pixels += 1, count.lost += measured(range) ? 0 : 1;
  });
}

}  // namespace scslam::sim
