// Where a radar's antenna sends its power, and how to draw rays by it.
#pragma once
#include <vector>

namespace scslam::sim {

/// One-way power patterns, 1 in the middle of the beam: Gaussian in azimuth; in elevation Gaussian with a cosec^2 tail
/// below, which lights the ground evenly (from the half-power point down).
class RadarAntenna {
 public:
  /// Half-power widths [rad]. @param lowest elevation of the tail, downwards positive [rad]; 0: no tail.
  RadarAntenna(double beam_azimuth, double beam_elevation, double lowest);

  /// @param azimuth from the middle of the beam [rad].
  double azimuthGain(double azimuth) const;
  double elevationGain(double elevation) const;
  /// Beyond this azimuth nothing is seen of even the strongest return [rad]: two-way gain below -95 dB.
  double azimuthReach() const { return 4.7 * azimuth_sigma_; }

  /// An elevation drawn in proportion to the gain, and its density [1/rad]. @param u in (0, 1).
  struct Elevation {
    double angle, density;
  };
  Elevation draw(double u) const;

 private:
  double azimuth_sigma_, elevation_sigma_, half_power_, lowest_;
  double first_, cell_;             ///< elevation of the first cell's lower end, size of a cell [rad]
  std::vector<double> cumulative_;  ///< up to the end of each cell, the last is 1
};

}  // namespace scslam::sim
