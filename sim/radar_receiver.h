// From echoes to what a radar writes down: one row of power in 8 bits.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/radar_echoes.h"

namespace scslam::sim {

/// Every echo is a scatterer of random phase: its complex amplitude, spread by the range response (Gaussian) and
/// weighted with the antenna's pattern in azimuth, is added to its neighbours'. So power in a cell is exponential
/// (speckle) with the right mean, as wide as the response in range and as the beam in azimuth. Thermal noise passes
/// through the same range response and is another one in each row. Without speckle, powers are added.
class RadarReceiver {
 public:
  RadarReceiver(const RadarModel& model, const RadarAntenna& antenna, const CounterRandom& random,
                std::uint32_t scan_number);

  /// Rows on either side whose echoes a row still sees.
  int reach() const { return reach_; }
  /// Received power of each bin [quanta].
  /// @param rows echoes of the rows number - reach … number + reach, the row itself in the middle.
  std::vector<float> power(std::span<const std::vector<RadarEcho>> rows, std::uint32_t number) const;
  /// Limits at saturation and compresses.
  void compress(std::span<const float> power, std::span<std::uint8_t> levels) const;

 private:
  struct Line;
  void addEchoes(std::span<const std::vector<RadarEcho>> rows, Line& line) const;
  void addNoise(std::uint32_t number, Line& line) const;
  void add(double position, float re, float im, Line& line) const;
  double position(double range) const { return (range - offset_) / resolution_; }
  std::uint8_t level(double power) const;

  const RadarModel& model_;
  const RadarAntenna& antenna_;
  const CounterRandom& random_;
  std::uint32_t scan_;
  int reach_ = 0;
  double resolution_, offset_, row_width_;
  double sigma_;                              ///< of the range response's amplitude [bins]
  double saturation_, streak_, phase_noise_;  ///< [quanta], factor
  std::size_t half_ = 0, taps_ = 0;           ///< of a response [bins]
  std::size_t noise_step_ = 1;                ///< between the sources of noise [bins]
  double noise_squares_ = 0;                  ///< sum of the squared responses of those that meet in a bin
  std::vector<float> response_;               ///< kFractions x taps_: amplitude
  std::vector<std::uint8_t> table_;           ///< levels of small powers, rounded
};

}  // namespace scslam::sim
