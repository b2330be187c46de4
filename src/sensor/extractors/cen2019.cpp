// S. H. Cen, P. Newman, "Radar-only ego-motion estimation in difficult settings via graph matching", ICRA 2019, section
// III: bins are ranked by h = (1 - g) s, with s the power less its mean and g the gradient along range, 1 at most; from
// the best on, each is grown in its row until s < 0, up to l_max regions, of which those stay that touch one in a
// neighbouring azimuth. Growing so makes a region of every run of bins with s >= 0, whichever of them comes first: the
// runs are ranked by their best h, no bins are sorted. (Known code grows while s < 0, which yields single bins.)
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "scslam/sensor/radar_detections.h"
#include "scslam/sensor/radar_extractor.h"

namespace scslam {
namespace {

struct Region {
  std::size_t azimuth = 0, begin = 0, end = 0;  ///< bins [begin, end) of a row
  std::size_t best = 0;                         ///< bin of the greatest h
  float h = 0;
};

/// Sums and extremes of a row that the whole image needs.
struct RowFigures {
  std::uint64_t power = 0;
  int steepest = 0;
  double h = 0;
};

int steepness(std::span<const std::uint8_t> row, std::size_t bin) {
  return std::abs(static_cast<int>(row[bin + 1]) - static_cast<int>(row[bin - 1]));
}

class Cen2019 final : public RadarExtractor {
 public:
  struct Params : ParamSetOf<Params>, RadarWindowParams {
    int max_regions = 10000;
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
    const std::vector<std::vector<Region>> regions = connected(strongest(regionsOf(scan, bins), scan.azimuths));
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
  std::vector<Region> regionsOf(const RadarScan& scan, const RadarWindowParams::Bins& bins) const {
    std::vector<RowFigures> figures(scan.azimuths);
    forEachRow(scan, [&](std::size_t azimuth) {
      const auto row = scan.row(azimuth);
      RowFigures& f = figures[azimuth];
      for (std::size_t i = bins.begin; i < bins.end; ++i) {
        f.power += row[i];
        f.steepest = std::max(f.steepest, steepness(row, i));
      }
    });
    std::uint64_t power = 0, rows = 0;
    int steepest = 1;
    for (std::size_t azimuth = 0; azimuth < scan.azimuths; ++azimuth) {
      power += figures[azimuth].power, rows += scan.valid[azimuth] != 0;
      steepest = std::max(steepest, figures[azimuth].steepest);
    }
    if (rows == 0 || power == 0) return {};
    const auto cells = static_cast<double>(rows * (bins.end - bins.begin));
    const auto mean = static_cast<float>(static_cast<double>(power) / cells);
    std::vector<std::vector<Region>> runs(scan.azimuths);
    const float per_step = 1 / static_cast<float>(steepest);
    forEachRow(scan, [&](std::size_t azimuth) {
      figures[azimuth].h = runsOf(scan.row(azimuth), azimuth, bins, mean, per_step, runs[azimuth]);
    });
    double h = 0;
    for (const RowFigures& f : figures) h += f.h;
    std::vector<Region> regions;
    for (const auto& row : runs)
      std::copy_if(row.begin(), row.end(), std::back_inserter(regions),
                   [&](const Region& region) { return static_cast<double>(region.h) > h / cells; });
    return regions;
  }

  /// @return sum of h over the row.
  static double runsOf(std::span<const std::uint8_t> row, std::size_t azimuth, const RadarWindowParams::Bins& bins,
                       float mean, float per_step, std::vector<Region>& runs) {
    float sum = 0;
    bool inside = false;
    for (std::size_t i = bins.begin; i < bins.end; ++i) {
      const float s = static_cast<float>(row[i]) - mean;
      const float h = s * (1 - per_step * static_cast<float>(steepness(row, i)));
      sum += h;
      if (s < 0) {
        inside = false;
      } else if (!inside) {
        runs.push_back({azimuth, i, i + 1, i, h});
        inside = true;
      } else {
        Region& run = runs.back();
        run.end = i + 1;
        if (h > run.h) run.h = h, run.best = i;
      }
    }
    return static_cast<double>(sum);
  }

  /// The max_regions best, row by row and outwards.
  std::vector<std::vector<Region>> strongest(std::vector<Region> regions, std::size_t azimuths) const {
    const auto most = static_cast<std::size_t>(params_.max_regions);
    const auto before = [](const Region& a, const Region& b) {
      if (a.h != b.h) return a.h > b.h;
      return a.azimuth != b.azimuth ? a.azimuth < b.azimuth : a.begin < b.begin;
    };
    if (regions.size() > most) {
      std::nth_element(regions.begin(), regions.begin() + params_.max_regions, regions.end(), before);
      regions.resize(most);
      std::sort(regions.begin(), regions.end(), [](const Region& a, const Region& b) {
        return a.azimuth != b.azimuth ? a.azimuth < b.azimuth : a.begin < b.begin;
      });
    }
    std::vector<std::vector<Region>> rows(azimuths);
    for (const Region& region : regions) rows[region.azimuth].push_back(region);
    return rows;
  }

  /// Those that share a bin of range with one of the azimuths beside theirs; the last lies beside the first.
  static std::vector<std::vector<Region>> connected(const std::vector<std::vector<Region>>& rows) {
    std::vector<std::vector<Region>> kept(rows.size());
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
    const std::size_t first = std::max(region.begin, region.best - std::min(region.best, bins.half_width));
    const std::size_t last = std::min(region.end, region.best + bins.half_width + 1);
    std::size_t peak = region.best;
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
