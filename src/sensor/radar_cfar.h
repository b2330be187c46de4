// Detection with a constant rate of false alarms: a peak is tested against the cells around it.
#pragma once
#include <array>
#include <vector>

#include "scslam/sensor/radar_detections.h"

namespace scslam {

/// Linear power of each grey level of a receiver that is logarithmic.
class LinearPower {
 public:
  /// @param counts_per_db grey levels a decibel (Navtech: 2).
  explicit LinearPower(double counts_per_db);
  double operator()(std::uint8_t level) const { return of_level_[level]; }

 private:
  std::array<double, 256> of_level_{};
};

/// Parameters of all tests by cells around a peak.
struct CfarWindowParams : RadarWindowParams {
  double window_m = 3.0;  ///< reference cells on each side
  double guard_m = 1.0;   ///< left out between the peak and them on each side: its own echo
  double counts_per_db = 2;
  int min_power = 30;

  void describeCfar(ParamVisitor& v);
};

/// The reference cells of one row's bins: [near_begin, near_end) before, [far_begin, far_end) behind; cut at the ends
/// of what is looked at.
struct ReferenceCells {
  std::size_t near_begin = 0, near_end = 0, far_begin = 0, far_end = 0;
  std::size_t count() const { return near_end - near_begin + far_end - far_begin; }
};

class CfarWindow {
 public:
  CfarWindow(const CfarWindowParams& params, const RadarScan& scan);
  const RadarWindowParams::Bins& bins() const { return bins_; }
  std::size_t cellsWhenComplete() const { return 2 * window_; }
  ReferenceCells around(std::size_t bin) const;

 private:
  RadarWindowParams::Bins bins_;
  std::size_t window_, guard_;
};

/// Sum of the linear power of the first i bins.
void prefixSums(std::span<const std::uint8_t> row, const LinearPower& linear, std::vector<double>& sums);
/// Mean over the reference cells. @param sums of prefixSums.
double meanPower(const ReferenceCells& cells, const std::vector<double>& sums);

/// Factor on the mean of n cells of exponentially distributed power for a rate of false alarms: n (Pfa^(-1/n) - 1).
double cellAveragingFactor(double false_alarm_rate, std::size_t n);
/// Factor on the k-th smallest (1-based) of n such cells: Pfa = prod_{i<k} (n - i) / (n - i + factor) solved for it
/// (H. Rohling, "Radar CFAR thresholding in clutter and multiple target situations", IEEE T-AES 1983, eq. 37).
double orderedStatisticFactor(double false_alarm_rate, std::size_t n, std::size_t k);

}  // namespace scslam
