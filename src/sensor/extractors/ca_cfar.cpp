// CA-CFAR: a peak must exceed the mean of the cells around it by the factor that gives the wanted rate of false alarms
// (H. M. Finn, R. S. Johnson, "Adaptive detection mode with threshold control as a function of spatially sampled
// clutter-level estimates", RCA Review 1968).
#include "scslam/sensor/radar_cfar.h"
#include "scslam/sensor/radar_extractor.h"

namespace scslam {
namespace {

class CellAveraging final : public RadarExtractor {
 public:
  struct Params : ParamSetOf<Params>, CfarWindowParams {
    double false_alarm_rate = 1e-3;
    void describe(ParamVisitor& v) override {
      v.field("false_alarm_rate", false_alarm_rate, "of a cell that holds noise alone", 1e-12, 0.5);
      describeCfar(v);
    }
  };
  CellAveraging(const Params& params, const PluginContext& context)
      : params_(params), threads_(context.threads), linear_(params.counts_per_db) {}

  Cloud extract(const RadarScan& scan) const override {
    const CfarWindow window(params_, scan);
    const double factor = cellAveragingFactor(params_.false_alarm_rate, window.cellsWhenComplete());
    return radarCloud(scan, threads_, [&](std::size_t azimuth, std::vector<RadarDetection>& detections) {
      thread_local std::vector<std::size_t> peaks;
      thread_local std::vector<double> sums;
      const auto row = scan.row(azimuth);
      findPeaks(row, window.bins(), params_.min_power, peaks);
      if (peaks.empty()) return;
      prefixSums(row, linear_, sums);
      for (const std::size_t bin : peaks) {
        const ReferenceCells cells = window.around(bin);
        if (cells.count() != 0 && linear_(row[bin]) > factor * meanPower(cells, sums))
          detections.push_back(refinedPeak(row, bin, window.bins().half_width));
      }
    });
  }

 private:
  Params params_;
  ThreadPool& threads_;
  LinearPower linear_;
};

}  // namespace

SCSLAM_REGISTER(RadarExtractor, CellAveraging, "ca_cfar", "peaks above the mean of the cells around them")

}  // namespace scslam
