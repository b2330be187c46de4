#include "sim/realism.h"

#include <complex>
#include <numbers>

#include "sim/surface_figures.h"

namespace scslam::sim {
namespace {

/// A rate is known from so many pixels, or from so many drop-outs.
bool enough(const DropoutCount& count) { return count.pixels >= 1000 || count.lost >= 20; }

constexpr int kLowRings = 20;

Points pointsOf(const RangeImage& image, const Cloud& cloud) {
  Points points;
  for (const std::int32_t i : image.point)
    if (i >= 0) points.push_back(cloud.point(static_cast<std::size_t>(i)).cast<double>());
  return points;
}

/// The values of one ring over the scans in which it was measured.
std::vector<double> overScans(const std::vector<std::vector<double>>& scans, std::size_t ring) {
  std::vector<double> values;
  for (const auto& scan : scans)
    if (measured(scan[ring])) values.push_back(scan[ring]);
  return values;
}

}  // namespace

RealismMeter::RealismMeter(SensorModel sensor) : sensor_(std::move(sensor)) {}

bool RealismMeter::add(const Cloud& cloud) {
  const RangeImage image = organise(cloud, sensor_);
  if (image.on_ring == 0) {
    ++skipped_;
    return false;
  }
  RealismFigures f;
  measureReturns(image, f);
  measureGrid(image, cloud, f);
  measureDropouts(image, f, by_range_);
  measureEdges(image, f);
  measureNoise(image, f);
  const Points points = pointsOf(image, cloud);
  measureGround(points, f);
  measureSpacing(points, image.columns, f);
  measureShape(points, f);
  measureScanContext(points, f);

  const std::string why_no_signal = sim::whyNoSignal(image, cloud);
  if (why_no_signal.empty()) countBySignal(image, cloud, by_signal_);
  if (why_no_signal_.empty()) why_no_signal_ = why_no_signal;
  const std::string ring_source = toString(image.ring_source);
  ring_source_ = scans_.empty() || ring_source_ == ring_source ? ring_source : "mixed";
  seen_.resize(image.point.size(), 0);
  for (std::size_t pixel = 0; pixel < seen_.size(); ++pixel) seen_[pixel] += image.point[pixel] >= 0 ? 1 : 0;
  elevation_deg_.push_back(image.elevation_deg);
  phase_step_.push_back(image.phase_step);
  scans_.push_back(std::move(f));
  return true;
}

RealismFigures RealismMeter::figures() const {
  RealismFigures f = medianOf(scans_);
  if (scans_.empty()) return f;
  for (const RealismFigures& scan : scans_) {
    f.return_rate_min = std::min(f.return_rate_min, scan.return_rate);
    f.return_rate_max = std::max(f.return_rate_max, scan.return_rate);
  }
  f.elevation_off_deg = largestElevationOffset();
  f.azimuth_drift_step = largestPhaseDrift();
  putSeenPixels(f);
  putDropouts(f);
  return f;
}

void RealismMeter::putSeenPixels(RealismFigures& f) const {
  const auto rings = static_cast<std::size_t>(sensor_.rings), columns = static_cast<std::size_t>(sensor_.columns);
  std::vector<bool> column_seen(columns, false), seen_low(columns, false);
  for (std::size_t ring = 0; ring < rings; ++ring) {
    double ever = 0, returns = 0;
    for (std::size_t column = 0; column < columns; ++column) {
      const std::uint32_t seen = seen_[ring * columns + column];
      returns += seen;
      if (seen == 0) continue;
      ever += 1;
      column_seen[column] = true;
      if (ring < kLowRings) seen_low[column] = true;
    }
    f.ring_never_seen.push_back(static_cast<double>(columns) - ever);
    f.ring_rate_seen.push_back(share(returns, ever * static_cast<double>(scans_.size())));
  }
  f.columns_never_seen = static_cast<double>(std::count(column_seen.begin(), column_seen.end(), false));
  f.low_ring_columns_never_seen = static_cast<double>(std::count(seen_low.begin(), seen_low.end(), false));
}

void RealismMeter::putDropouts(RealismFigures& f) const {
  for (std::size_t bin = 0; bin < by_range_.size(); ++bin)
    if (!enough(by_range_[bin])) f.dropout_by_range[bin] = kNotMeasured;
  if (!why_no_signal_.empty()) return;
  for (const DropoutCount& count : by_signal_)
    f.dropout_by_signal.push_back(enough(count) ? share(count.lost, count.pixels) : kNotMeasured);
}

double RealismMeter::largestElevationOffset() const {
  double largest = kNotMeasured;
  for (std::size_t ring = 0; ring < sensor_.elevation_deg.size(); ++ring)
    largest = std::fmax(largest, std::abs(median(overScans(elevation_deg_, ring)) - sensor_.elevation_deg[ring]));
  return largest;
}

double RealismMeter::largestPhaseDrift() const {
  double largest = kNotMeasured;
  for (std::size_t ring = 0; ring < static_cast<std::size_t>(sensor_.rings); ++ring) {
    const std::vector<double> phases = overScans(phase_step_, ring);
    std::complex<double> sum = 0;
    for (const double phase : phases) sum += std::polar(1.0, 2 * std::numbers::pi * phase);
    const double mean = std::arg(sum) / (2 * std::numbers::pi);
    for (const double phase : phases) largest = std::fmax(largest, std::abs(std::remainder(phase - mean, 1.0)));
  }
  return largest;
}

}  // namespace scslam::sim
