// S. H. Cen, P. Newman, "Radar-only ego-motion estimation in difficult settings via graph matching", ICRA 2019, section
// III: bins are ranked by h = (1 - g) s, with s the power less its mean and g the gradient along range, 1 at most; from
// the best on, each is grown in its row until s < 0, up to l_max regions, of which those stay that touch one in a
// neighbouring azimuth. Growing so makes a region of every run of bins with s >= 0, whichever of them comes first: the
// runs are ranked by their best h, no bins are sorted. (Known code grows while s < 0, which yields single bins.)
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>

#include "scslam/core/simd.h"
#include "scslam/sensor/radar_detections.h"
#include "scslam/sensor/radar_extractor.h"

namespace scslam {
namespace {

struct Region {
  std::uint32_t begin = 0, end = 0;  ///< bins [begin, end) of a row
  std::uint32_t best = 0;            ///< bin of the greatest h
  float h = 0;
};
using Rows = std::vector<std::vector<Region>>;  ///< per azimuth, outwards

constexpr std::size_t kLanes = 16;

/// Sums and extremes of a row that the whole image needs.
struct RowFigures {
  std::uint64_t power = 0;
  int steepest = 0;
  double h = 0;
};

int steepness(const std::uint8_t* bin) { return std::abs(static_cast<int>(bin[1]) - static_cast<int>(bin[-1])); }

/// @param row n bins with a neighbour before the first and behind the last.
SCSLAM_KERNEL RowFigures figuresOf(const std::uint8_t* row, std::size_t n) {
  std::uint32_t power[kLanes] = {};
  int steepest[kLanes] = {};
  const std::size_t whole = n - n % kLanes;
  for (std::size_t i = 0; i < whole; i += kLanes)
    for (std::size_t k = 0; k < kLanes; ++k) {
      power[k] += row[i + k];
      steepest[k] = std::max(steepest[k], steepness(row + i + k));
    }
  RowFigures f;
  for (std::size_t k = 0; k < kLanes; ++k) f.power += power[k], f.steepest = std::max(f.steepest, steepest[k]);
  for (std::size_t i = whole; i < n; ++i) f.power += row[i], f.steepest = std::max(f.steepest, steepness(row + i));
  return f;
}

/// h of n bins. Where n is no multiple of kLanes, there must be room in both up to the next one. @return sum of all h.
SCSLAM_KERNEL double rankBins(const std::uint8_t* __restrict row, std::size_t n, float mean, float per_step,
                              float* __restrict h) {
  float sum[kLanes] = {};
  const std::size_t whole = n - n % kLanes;
  for (std::size_t i = 0; i < n; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k)
      h[i + k] = (static_cast<float>(row[i + k]) - mean) * (1 - per_step * static_cast<float>(steepness(row + i + k)));
    if (i < whole)
      for (std::size_t k = 0; k < kLanes; ++k) sum[k] += h[i + k];
  }
  double total = 0;
  for (const float lane : sum) total += static_cast<double>(lane);
  for (std::size_t i = whole; i < n; ++i) total += static_cast<double>(h[i]);
  return total;
}

class Cen2019 final : public RadarExtractor {
 public:
  struct Params : ParamSetOf<Params>, RadarWindowParams {
    int max_regions = 2000;
    void describe(ParamVisitor& v) override {
      v.field("max_regions", max_regions, "l_max: at most so many regions a sweep are grown", 1, 10'000'000);
      describeWindow(v);
    }
  };
  Cen2019(const Params& params, const PluginContext& context) : params_(params), threads_(context.threads) {}

  Cloud extract(const RadarScan& scan) const override {
    auto bins = params_.binsOf(scan);
    bins.begin = std::max<std::size_t>(bins.begin, 1),
    bins.end = std::min(bins.end, scan.bins - std::min<std::size_t>(1, scan.bins));
    if (bins.end <= bins.begin || !scan.consistent()) return {};
    const Rows regions = connected(strongest(regionsOf(scan, bins)));
    return radarCloud(scan, threads_, [&](std::size_t azimuth, std::vector<RadarDetection>& detections) {
      for (const Region& region : regions[azimuth])
        detections.push_back(refinedPeak(scan.row(azimuth), peakOf(scan.row(azimuth), region, bins), bins.half_width));
    });
  }

 private:
  static constexpr std::size_t kRowsPerChunk = 50;

  template <class Body>
  void forEachRow(const RadarScan& scan, const Body& body) const {
    threads_.forEachChunk(scan.azimuths, kRowsPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
      for (std::size_t azimuth = begin; azimuth < end; ++azimuth)
        if (scan.valid[azimuth] != 0) body(azimuth);
    });
  }

  /// All runs of bins with s >= 0 whose best h is above the mean of h.
  Rows regionsOf(const RadarScan& scan, const RadarWindowParams::Bins& bins) const {
    std::vector<RowFigures> figures(scan.azimuths);
    forEachRow(scan, [&](std::size_t azimuth) {
      figures[azimuth] = figuresOf(scan.row(azimuth).data() + bins.begin, bins.end - bins.begin);
    });
    std::uint64_t power = 0, rows = 0;
    int steepest = 1;
    for (std::size_t azimuth = 0; azimuth < scan.azimuths; ++azimuth) {
      power += figures[azimuth].power, rows += scan.valid[azimuth] != 0;
      steepest = std::max(steepest, figures[azimuth].steepest);
    }
    Rows regions(scan.azimuths);
    if (rows == 0 || power == 0) return regions;
    const auto cells = static_cast<double>(rows * (bins.end - bins.begin));
    const auto mean = static_cast<float>(static_cast<double>(power) / cells);
    const float per_step = 1 / static_cast<float>(steepest);
    forEachRow(scan, [&](std::size_t azimuth) {
      figures[azimuth].h = runsOf(scan.row(azimuth), bins, mean, per_step, regions[azimuth]);
    });
    double h = 0;
    for (const RowFigures& f : figures) h += f.h;
    for (auto& row : regions)
      std::erase_if(row, [&](const Region& region) { return static_cast<double>(region.h) <= h / cells; });
    return regions;
  }

  /// @return sum of h over the row.
  static double runsOf(std::span<const std::uint8_t> row, const RadarWindowParams::Bins& bins, float mean,
                       float per_step, std::vector<Region>& runs) {
    thread_local std::vector<float> h;
    thread_local std::vector<std::uint8_t> padded;
    const std::size_t n = bins.end - bins.begin;
    padded.assign(row.begin() + static_cast<std::ptrdiff_t>(bins.begin) - 1,
                  row.begin() + static_cast<std::ptrdiff_t>(bins.end) + 1);
    padded.resize(n + 2 + kLanes);
    h.resize(n + kLanes);
    const double sum = rankBins(padded.data() + 1, n, mean, per_step, h.data());
    const auto least = static_cast<std::uint8_t>(std::min(255.0F, std::ceil(mean)));  // s >= 0
    const auto at = [&bins](std::size_t i) { return static_cast<std::uint32_t>(bins.begin + i); };
    for (std::size_t i = 0; i < n; ++i) {
      if (padded[i + 1] < least) continue;
      Region run{at(i), 0, at(i), h[i]};
      for (; i < n && padded[i + 1] >= least; ++i)
        if (h[i] > run.h) run.h = h[i], run.best = at(i);
      run.end = at(i);
      runs.push_back(run);
    }
    return sum;
  }

  /// The max_regions best; of equally good ones the first.
  Rows strongest(Rows rows) const {
    const auto most = static_cast<std::size_t>(params_.max_regions);
    std::vector<float> h;
    for (const auto& row : rows)
      for (const Region& region : row) h.push_back(region.h);
    if (h.size() <= most) return rows;
    std::nth_element(h.begin(), h.begin() + params_.max_regions - 1, h.end(), std::greater<>());
    const float least = h[most - 1];
    // How many of those that are exactly as good as the least have room.
    auto room = static_cast<std::ptrdiff_t>(most) -
                std::count_if(h.begin(), h.end(), [least](float other) { return other > least; });
    for (auto& row : rows)
      std::erase_if(row, [&](const Region& r) { return r.h < least || (r.h == least && room-- <= 0); });
    return rows;
  }

  /// Those that share a bin of range with one of the azimuths beside theirs; the last lies beside the first.
  static Rows connected(const Rows& rows) {
    Rows kept(rows.size());
    const auto touches = [&](const Region& region, std::size_t azimuth) {
      const auto& other = rows[azimuth];
      const auto behind =
          std::partition_point(other.begin(), other.end(), [&](const Region& r) { return r.end <= region.begin; });
      return behind != other.end() && behind->begin < region.end;
    };
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (const Region& region : rows[i])
        if (touches(region, (i + 1) % rows.size()) || touches(region, (i + rows.size() - 1) % rows.size()))
          kept[i].push_back(region);
    return kept;
  }

  /// h is greatest where the echo is flat: near its top, which is looked for within an echo's width.
  static std::size_t peakOf(std::span<const std::uint8_t> row, const Region& region,
                            const RadarWindowParams::Bins& bins) {
    const std::size_t best = region.best;
    const std::size_t first = std::max<std::size_t>(region.begin, best - std::min(best, bins.half_width));
    const std::size_t last = std::min<std::size_t>(region.end, best + bins.half_width + 1);
    std::size_t peak = best;
    for (std::size_t i = first; i < last; ++i)
      if (row[i] > row[peak]) peak = i;
    return peak;
  }

  Params params_;
  ThreadPool& threads_;
};

}  // namespace

SCSLAM_REGISTER(RadarExtractor, Cen2019, "cen2019", "regions of high power and little slope (Cen and Newman 2019)")

}  // namespace scslam
