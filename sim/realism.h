// How do scans look to a SLAM program? Measures the figures of a set of scans, real or simulated, by the same rules.
//
//   RealismMeter meter(sensor);
//   while (auto scan = source->next()) meter.add(scan->cloud);
//   const RealismFigures figures = meter.figures();        // then scoreRealism(…), sim/realism_score.h
#pragma once
#include <string>
#include <vector>

#include "sim/image_figures.h"
#include "sim/realism_figures.h"

namespace scslam::sim {

/// Memory grows with the number of scans by a few kilobytes each; the scans themselves are not kept.
class RealismMeter {
 public:
  /// @param sensor the table that the scans are laid out by; see organise() for what it must say.
  explicit RealismMeter(SensorModel sensor);

  /// Measures one sweep. @param cloud frame: sensor, z up, not preprocessed; NaN points and the origin are no return.
  /// @return false when no point lies on a ring of the table; such a scan counts for nothing.
  bool add(const Cloud& cloud);

  /// Of all scans added. A drop-out rate from fewer than 1000 pixels and 20 drop-outs is not measured.
  RealismFigures figures() const;

  std::size_t scans() const { return scans_.size(); }
  std::size_t skipped() const { return skipped_; }
  const SensorModel& sensor() const { return sensor_; }
  /// How the rings were known: in the words of toString(RingSource), "mixed" when not the same for all scans.
  const std::string& ringSource() const { return ring_source_; }
  /// Why dropout_by_signal was not measured; empty when it was.
  const std::string& whyNoSignal() const { return why_no_signal_; }

 private:
  void putSeenPixels(RealismFigures& figures) const;
  void putDropouts(RealismFigures& figures) const;
  double largestElevationOffset() const;
  double largestPhaseDrift() const;

  SensorModel sensor_;
  std::vector<RealismFigures> scans_;
  std::size_t skipped_ = 0;
  std::string ring_source_, why_no_signal_;
  std::vector<std::uint32_t> seen_;                 ///< scans in which the pixel returned
  std::vector<std::vector<double>> elevation_deg_;  ///< per scan and ring
  std::vector<std::vector<double>> phase_step_;     ///< per scan and ring
  RangeCounts by_range_{};
  SignalCounts by_signal_{};
};

}  // namespace scslam::sim
