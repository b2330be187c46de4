// S. H. Cen, P. Newman, "Precise ego-motion estimation with millimeter-wave radar under diverse and challenging
// conditions", ICRA 2018, algorithm 1: a row without its mean q is split into what is smooth, p, and what is not; both
// count as far as they are unlikely to be noise, whose sigma the negative part of q tells.
#include <algorithm>
#include <cmath>

#include "scslam/core/simd.h"
#include "scslam/sensor/radar_detections.h"
#include "scslam/sensor/radar_extractor.h"

namespace scslam {
namespace {

constexpr std::size_t kLanes = 8, kBlock = 4 * kLanes;  // four vectors of sums stay in registers

/// sum_t taps[t] * in[i + t] for i < n. @param in has n + tap_count - 1 values, and room for kBlock more.
SCSLAM_KERNEL void correlate(const float* in, std::size_t n, const float* taps, std::size_t tap_count, float* out) {
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    float a[kLanes] = {}, b[kLanes] = {}, c[kLanes] = {}, d[kLanes] = {};
    for (std::size_t t = 0; t < tap_count; ++t) {
      const float tap = taps[t];
      const float* from = in + begin + t;
      for (std::size_t k = 0; k < kLanes; ++k) a[k] += tap * from[k];
      for (std::size_t k = 0; k < kLanes; ++k) b[k] += tap * from[k + kLanes];
      for (std::size_t k = 0; k < kLanes; ++k) c[k] += tap * from[k + 2 * kLanes];
      for (std::size_t k = 0; k < kLanes; ++k) d[k] += tap * from[k + 3 * kLanes];
    }
    float* to = out + begin;
    for (std::size_t k = 0; k < kLanes; ++k)
      to[k] = a[k], to[k + kLanes] = b[k], to[k + 2 * kLanes] = c[k], to[k + 3 * kLanes] = d[k];
  }
}

SCSLAM_KERNEL void lessMean(const std::uint8_t* __restrict values, std::size_t n, float mean, float* __restrict out) {
  const std::size_t whole = n - n % kLanes;
  for (std::size_t i = 0; i < whole; i += kLanes)
    for (std::size_t k = 0; k < kLanes; ++k) out[i + k] = static_cast<float>(values[i + k]) - mean;
  for (std::size_t i = whole; i < n; ++i) out[i] = static_cast<float>(values[i]) - mean;
}

/// Number, sum and sum of squares of the values below `limit`.
struct Moments {
  std::uint32_t count = 0, sum = 0, squares = 0;
};
SCSLAM_KERNEL Moments momentsBelow(const std::uint8_t* values, std::size_t n, int limit) {
  constexpr std::size_t kWide = 16;
  std::uint32_t count[kWide] = {}, sum[kWide] = {}, squares[kWide] = {};
  const std::size_t whole = n - n % kWide;
  for (std::size_t i = 0; i < whole; i += kWide)
    for (std::size_t k = 0; k < kWide; ++k) {
      const std::uint32_t value = values[i + k], below = static_cast<int>(value) < limit ? 1 : 0;
      count[k] += below, sum[k] += below * value, squares[k] += below * value * value;
    }
  Moments m;
  for (std::size_t k = 0; k < kWide; ++k) m.count += count[k], m.sum += sum[k], m.squares += squares[k];
  for (std::size_t i = whole; i < n; ++i)
    if (values[i] < limit) ++m.count, m.sum += values[i], m.squares += std::uint32_t{values[i]} * values[i];
  return m;
}

class Cen2018 final : public RadarExtractor {
 public:
  struct Params : ParamSetOf<Params>, RadarWindowParams {
    double smooth_m = 0.73;
    double z_score = 3;
    void describe(ParamVisitor& v) override {
      v.field("smooth_m", smooth_m, "sigma of the Gaussian that makes p of q [m]", 0.001, 10);
      v.field("z_score", z_score, "what counts must exceed so many sigmas of the noise", 0, 100);
      describeWindow(v);
    }
  };
  Cen2018(const Params& params, const PluginContext& context) : params_(params), threads_(context.threads) {}

  Cloud extract(const RadarScan& scan) const override {
    const auto bins = params_.binsOf(scan);
    if (bins.end <= bins.begin) return {};
    const std::vector<float> taps = gaussian(params_.smooth_m / scan.range_resolution_m, bins.end - bins.begin);
    return radarCloud(scan, threads_, [&](std::size_t azimuth, std::vector<RadarDetection>& detections) {
      detect(scan.row(azimuth), bins, taps, detections);
    });
  }

 private:
  /// Cut at 1.5 sigma as the authors' successors do, and where a row is shorter than that.
  static std::vector<float> gaussian(double sigma, std::size_t row) {
    const double most = std::min(0.5 * static_cast<double>(row), 1000.0);
    const auto reach = static_cast<std::int64_t>(std::clamp(std::round(1.5 * sigma), 0.0, most));
    std::vector<double> weights;
    double sum = 0;
    for (std::int64_t x = -reach; x <= reach; ++x) {
      weights.push_back(std::exp(-0.5 * std::pow(static_cast<double>(x) / sigma, 2)));
      sum += weights.back();
    }
    std::vector<float> taps;
    for (const double weight : weights) taps.push_back(static_cast<float>(weight / sum));
    return taps;
  }

  /// The row less its mean, mirrored at both ends by `reach` values. @return sigma of its noise.
  static float unbiased(std::span<const std::uint8_t> row, std::size_t reach, std::vector<float>& q) {
    const Moments all = momentsBelow(row.data(), row.size(), 256);
    const double mean = static_cast<double>(all.sum) / static_cast<double>(row.size());
    q.resize(row.size() + 2 * reach + kBlock);
    lessMean(row.data(), row.size(), static_cast<float>(mean), q.data() + reach);
    for (std::size_t i = 0; i < reach; ++i) {
      q[reach - 1 - i] = q[reach + std::min(i, row.size() - 1)];
      q[reach + row.size() + i] = q[reach + row.size() - 1 - std::min(i, row.size() - 1)];
    }
    const Moments low = momentsBelow(row.data(), row.size(), static_cast<int>(std::ceil(mean)));
    if (low.count == 0) return 0;
    const double n = low.count, squares = low.squares - 2 * mean * low.sum + n * mean * mean;
    return static_cast<float>(std::sqrt(2 * squares / n));
  }

  void detect(std::span<const std::uint8_t> row, const RadarWindowParams::Bins& bins, const std::vector<float>& taps,
              std::vector<RadarDetection>& detections) const {
    thread_local std::vector<float> q, p;
    const std::size_t n = bins.end - bins.begin, reach = taps.size() / 2;
    const float sigma = unbiased(row.subspan(bins.begin, n), reach, q);
    if (!(sigma > 0)) return;  // nothing varies
    p.resize(n + kBlock);
    correlate(q.data(), n, taps.data(), taps.size(), p.data());
    const float threshold = static_cast<float>(params_.z_score) * sigma;
    // y <= max(q, p) + |p| exp(-p^2 / 2 sigma^2) <= max(q, p) + 0.61 sigma: most bins need no exponential.
    const float worth = threshold - 0.61F * sigma;
    std::size_t run = n, strongest = 0;  // begin of a run of bins above the threshold; n: none
    for (std::size_t i = 0; i <= n; ++i) {
      const bool above =
          i < n && std::max(q[reach + i], p[i]) >= worth && likely(q[reach + i], p[i], sigma) > threshold;
      if (above) {
        if (run == n) run = i, strongest = i;
        if (row[bins.begin + i] > row[bins.begin + strongest]) strongest = i;
      } else if (run != n) {
        detections.push_back(refinedPeak(row, bins.begin + strongest, bins.half_width));
        run = n;
      }
    }
  }

  /// Equation 3 of the paper: what of q and p is not noise.
  static float likely(float q, float p, float sigma) {
    const float n_qp = std::exp(-0.5F * (q - p) * (q - p) / (sigma * sigma));
    const float n_pp = std::exp(-0.5F * p * p / (sigma * sigma));
    return q * (1 - n_qp) + p * (n_qp - n_pp);
  }

  Params params_;
  ThreadPool& threads_;
};

}  // namespace

SCSLAM_REGISTER(RadarExtractor, Cen2018, "cen2018", "what stands out of a row's noise (Cen and Newman 2018)")

}  // namespace scslam
