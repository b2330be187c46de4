// BFAR: the threshold is an affine function of the mean around a peak, a * mean + b: where there is little noise the
// constant b keeps it up, near strong echoes the mean does (A. Alhashimi, D. Adolfsson, M. Magnusson, H. Andreasson,
// A. J. Lilienthal, "BFAR: Bounded False Alarm Rate detector for improved radar odometry estimation", 2021).
#include <cmath>

#include "scslam/sensor/radar_cfar.h"
#include "scslam/sensor/radar_extractor.h"

namespace scslam {
namespace {

class BoundedFalseAlarm final : public RadarExtractor {
 public:
  struct Params : ParamSetOf<Params>, CfarWindowParams {
    double scale = 1;
    double offset_power = 56;
    void describe(ParamVisitor& v) override {
      v.field("scale", scale, "a: how the threshold grows with the mean", 0, 1e6);
      v.field("offset_power", offset_power, "b: the threshold without any noise [grey levels]", 0, 255);
      describeCfar(v);
    }
  };
  BoundedFalseAlarm(const Params& params, const PluginContext& context)
      : params_(params),
        threads_(context.threads),
        linear_(params.counts_per_db),
        offset_(std::pow(10, params.offset_power / (10 * params.counts_per_db))) {}

  Cloud extract(const RadarScan& scan) const override {
    const CfarWindow window(params_, scan);
    return radarCloud(scan, threads_, [&](std::size_t azimuth, std::vector<RadarDetection>& detections) {
      thread_local std::vector<std::size_t> peaks;
      thread_local std::vector<double> sums;
      const auto row = scan.row(azimuth);
      findPeaks(row, window.bins(), params_.min_power, peaks);
      if (peaks.empty()) return;
      prefixSums(row, linear_, sums);
      for (const std::size_t bin : peaks) {
        const ReferenceCells cells = window.around(bin);
        if (cells.count() != 0 && linear_(row[bin]) > params_.scale * meanPower(cells, sums) + offset_)
          detections.push_back(refinedPeak(row, bin, window.bins().half_width));
      }
    });
  }

 private:
  Params params_;
  ThreadPool& threads_;
  LinearPower linear_;
  double offset_;  ///< linear
};

}  // namespace

SCSLAM_REGISTER(RadarExtractor, BoundedFalseAlarm, "bfar", "peaks above an affine function of the mean around them")

}  // namespace scslam
