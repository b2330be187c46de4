// The k strongest echoes of each azimuth above a fixed power: D. Adolfsson, M. Magnusson, A. Alhashimi, A. Lilienthal,
// H. Andreasson, "CFEAR Radarodometry: Conservative Filtering for Efficient and Accurate Radar Odometry", IROS 2021.
// There the k strongest bins are meant, most of which belong to one echo; `peaks_only` counts each echo once.
#include <algorithm>

#include "scslam/sensor/radar_detections.h"
#include "scslam/sensor/radar_extractor.h"

namespace scslam {
namespace {

class KStrongest final : public RadarExtractor {
 public:
  struct Params : ParamSetOf<Params>, RadarWindowParams {
    int k = 12;
    int min_power = 60;
    bool peaks_only = true;
    void describe(ParamVisitor& v) override {
      v.field("k", k, "at most so many points an azimuth", 1, 1000);
      v.field("min_power", min_power, "weaker bins are noise [grey levels]", 1, 255);
      v.field("peaks_only", peaks_only, "one point an echo, at its exact peak; false: every strong bin, as the paper");
      describeWindow(v);
    }
  };
  KStrongest(const Params& params, const PluginContext& context) : params_(params), threads_(context.threads) {}

  Cloud extract(const RadarScan& scan) const override {
    const auto bins = params_.binsOf(scan);
    return radarCloud(scan, threads_, [&](std::size_t azimuth, std::vector<RadarDetection>& detections) {
      thread_local std::vector<std::size_t> found;
      const auto row = scan.row(azimuth);
      if (params_.peaks_only)
        findPeaks(row, bins, params_.min_power, found);
      else
        strongBins(row, bins, found);
      keepStrongest(row, found);
      for (const std::size_t bin : found)
        detections.push_back(params_.peaks_only
                                 ? refinedPeak(row, bin, bins.half_width)
                                 : RadarDetection{static_cast<float>(bin) + 0.5F, static_cast<float>(row[bin])});
    });
  }

 private:
  void strongBins(std::span<const std::uint8_t> row, const RadarWindowParams::Bins& bins,
                  std::vector<std::size_t>& found) const {
    found.clear();
    for (std::size_t i = bins.begin; i < bins.end; ++i)
      if (row[i] >= params_.min_power) found.push_back(i);
  }

  /// Of equally strong ones the nearer; afterwards outwards again.
  void keepStrongest(std::span<const std::uint8_t> row, std::vector<std::size_t>& found) const {
    const auto k = static_cast<std::size_t>(params_.k);
    if (found.size() <= k) return;
    std::nth_element(found.begin(), found.begin() + params_.k, found.end(),
                     [row](std::size_t a, std::size_t b) { return row[a] != row[b] ? row[a] > row[b] : a < b; });
    found.resize(k);
    std::sort(found.begin(), found.end());
  }

  Params params_;
  ThreadPool& threads_;
};

}  // namespace

SCSLAM_REGISTER(RadarExtractor, KStrongest, "k_strongest", "the k strongest echoes of each azimuth above a fixed power")

}  // namespace scslam
