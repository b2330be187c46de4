// What a simulator, or an exact reader, knows of a spinning LiDAR beyond its elevations: where each beam leaves, when,
// how strong its echo must be. Data in configs/sensors/*.yaml, groups `beams` and `signal`.
#pragma once
#include <vector>

#include "scslam/core/params.h"

namespace scslam {

/// Geometry and timing of the beams. Lists are per ring, lowest first; a shorter list repeats, an empty one is zero.
struct BeamTable : ParamSetOf<BeamTable> {
  std::vector<double> azimuth_offset_deg;  ///< of each beam from its column's azimuth, counter-clockwise
  std::vector<double> time_us;             ///< when each beam fires after its column began; the head turns meanwhile
  std::vector<double> height_m;            ///< of each beam's origin above the sensor's
  std::vector<double> lateral_m;           ///< of each beam's origin to the left of its direction
  double origin_radius_m = 0;              ///< beams leave this far from the axis, along their column's azimuth
  double phase_deg = 0;                    ///< azimuth of column 0 in the sensor frame
  double column_s = 0;                     ///< time from column to column; 0: sweep_s / columns
  std::vector<double> blind_deg;           ///< azimuths that give nothing: from, to, from, to … counter-clockwise
  double range_quantum_m = 0.001;
  double divergence_mrad = 0;  ///< full width of the beam at half of its power
  double pulse_m = 0.6;        ///< echoes nearer to each other than this melt into one
  void describe(ParamVisitor& visitor) override;
};

/// Echo strength S = gain * rho f(theta) * near(r) / r^2 (in the sensor's own counts) of a surface of reflectance rho,
/// f its backscatter at incidence theta (cos theta for a matt one), and what follows from it. The defaults lose echoes
/// by range and by strength as real scans do (sim/targets/seosan01_os1-128.yaml).
struct SignalModel : ParamSetOf<SignalModel> {
  double gain = 150000;     ///< counts * m^2 for a white surface hit at a right angle
  double near_m = 10;       ///< below this range the receiver sees only part of the echo: (r / near_m)^near_power
  double near_power = 3.5;  ///<
  double floor = 3;         ///< weaker echoes are never seen
  double saturation = 7270;
  double retro_gain = 100;                       ///< a traffic sign is so many times as bright as white paint
  double sigma_m = 0.014, sigma_per_m = 0.0015;  ///< range noise: sigma_m + sigma_per_m r + sigma_signal_m S^-0.63
  double sigma_signal_m = 0;
  double dropout_base = 0.004;  ///< lost echoes: base + scale (signal / S)^power, at most dropout_most
  double dropout_scale = 0.217, dropout_signal = 9, dropout_power = 2.4, dropout_most = 0.45;
  void describe(ParamVisitor& visitor) override;
};

}  // namespace scslam
