// What real scans measure: the yardstick that simulated ones are held against (sim/targets/*.yaml).
#pragma once
#include <string>

#include "scslam/sensor/sensor_model.h"
#include "sim/realism_figures.h"

namespace scslam::sim {

/// Which parts of the sensor's grid the set keeps, and how exactly. A part with 0 is not to be found in this set (it
/// was deskewed, or its beams start beside the origin) and is checked in nobody's scans.
struct GridTolerance : ParamSetOf<GridTolerance> {
  double elevation_deg = 0.02;  ///< of a ring's median elevation from the table
  double azimuth_step = 0.02;   ///< off the azimuth grid, and drift of a ring's phase, in steps
  double range_quantum_m = 0;   ///< the ranges are multiples of this and of nothing coarser
  double column_time = 0.01;    ///< relative, of the time a column, where the points carry times
  void describe(ParamVisitor& visitor) override;
};

struct RealismTarget : ParamSetOf<RealismTarget> {
  std::string name, about;
  SensorModel sensor;  ///< the table its figures were measured with
  GridTolerance grid;
  RealismFigures figures;
  void describe(ParamVisitor& visitor) override;
};

/// @param text YAML. A number that was not measured is absent, within a list it is -1.
/// @param source its name, for messages.
/// @throw usageError as loadYaml(), and when a list has not the length that its bins or the sensor's rings ask for.
RealismTarget loadRealismTarget(const std::string& text, const std::string& source);

/// The YAML that loadRealismTarget() reads back, numbers to five digits.
std::string targetYaml(const RealismTarget& target);

}  // namespace scslam::sim
