// OS-CFAR: a peak must exceed the k-th smallest of the cells around it by the factor that gives the wanted rate of
// false alarms; a second echo among the cells does not hide it (H. Rohling, IEEE T-AES 1983).
#include <algorithm>
#include <cmath>

#include "scslam/sensor/radar_cfar.h"
#include "scslam/sensor/radar_extractor.h"

namespace scslam {
namespace {

class OrderedStatistic final : public RadarExtractor {
 public:
  struct Params : ParamSetOf<Params>, CfarWindowParams {
    double false_alarm_rate = 1e-3;
    double rank = 0.75;
    void describe(ParamVisitor& v) override {
      v.field("false_alarm_rate", false_alarm_rate, "of a cell that holds noise alone", 1e-12, 0.5);
      v.field("rank", rank, "which of the cells, by power: 0.5 = the median", 0.01, 1);
      describeCfar(v);
    }
  };
  OrderedStatistic(const Params& params, const PluginContext& context) : params_(params), threads_(context.threads) {}

  Cloud extract(const RadarScan& scan) const override {
    const CfarWindow window(params_, scan);
    const std::size_t n = window.cellsWhenComplete();
    const double factor = orderedStatisticFactor(params_.false_alarm_rate, n, rankOf(n));
    const double above = 10 * params_.counts_per_db * std::log10(factor);  // the factor in grey levels
    return radarCloud(scan, threads_, [&](std::size_t azimuth, std::vector<RadarDetection>& detections) {
      thread_local std::vector<std::size_t> peaks;
      const auto row = scan.row(azimuth);
      findPeaks(row, window.bins(), params_.min_power, peaks);
      for (const std::size_t bin : peaks) {
        const ReferenceCells cells = window.around(bin);
        if (cells.count() != 0 && exceeds(row, cells, row[bin] - above))
          detections.push_back(refinedPeak(row, bin, window.bins().half_width));
      }
    });
  }

 private:
  std::size_t rankOf(std::size_t n) const {
    return std::max<std::size_t>(1, static_cast<std::size_t>(std::round(params_.rank * static_cast<double>(n))));
  }

  /// Is the k-th smallest cell below `level`: are at least k of them?
  bool exceeds(std::span<const std::uint8_t> row, const ReferenceCells& cells, double level) const {
    if (level <= 0) return false;
    const auto least_above = static_cast<std::uint8_t>(std::min(255.0, std::ceil(level)));
    std::size_t below = 0;
    for (std::size_t i = cells.near_begin; i < cells.near_end; ++i) below += row[i] < least_above;
    for (std::size_t i = cells.far_begin; i < cells.far_end; ++i) below += row[i] < least_above;
    return below >= rankOf(cells.count());
  }

  Params params_;
  ThreadPool& threads_;
};

}  // namespace

SCSLAM_REGISTER(RadarExtractor, OrderedStatistic, "os_cfar", "peaks above a ranked one of the cells around them")

}  // namespace scslam
