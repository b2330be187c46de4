// Sensor tables as data: configs/sensors/*.yaml.
#pragma once
#include <string>
#include <vector>

#include "scslam/core/cloud.h"
#include "scslam/core/params.h"
#include "scslam/sensor/beam_table.h"
#include "scslam/sensor/radar_table.h"

namespace scslam {

struct SensorModel : ParamSetOf<SensorModel> {
  std::string name = "unknown";
  int rings = 0;    ///< lasers; 0 = unknown
  int columns = 0;  ///< firings a sweep; 0 = unknown
  std::string order =
      "unorganised";      ///< column_major (ring = k mod rings), row_major (ring = k / columns) or unorganised
  double sweep_s = 0.1;   ///< duration of one sweep [s]
  bool clockwise = true;  ///< direction of rotation seen from above
  double min_range_m = 0.5, max_range_m = 120.0;
  std::vector<double> elevation_deg;              ///< per ring, lowest first; may be empty
  std::vector<double> translation_m = {0, 0, 0};  ///< of T_base_sensor
  std::vector<double> rpy_deg = {0, 0, 0};        ///< of T_base_sensor: R = Rz(yaw) Ry(pitch) Rx(roll)

  BeamTable beams;
  SignalModel signal;
  RadarTable radar;

  void describe(ParamVisitor& visitor) override;
  Pose T_base_sensor() const;
};

/// Gives an organised cloud the ring and the time within the sweep that its format lacks, from the table.
/// @return what was made, in words ("ring = k mod 64, time by column"), empty when nothing.
std::string completeFromTable(Cloud& cloud, const SensorModel& sensor);

}  // namespace scslam
