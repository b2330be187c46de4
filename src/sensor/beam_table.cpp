#include "scslam/sensor/beam_table.h"

namespace scslam {

void BeamTable::describe(ParamVisitor& v) {
  v.field("azimuth_offset_deg", azimuth_offset_deg,
          "offset of each beam from its column's azimuth, counter-clockwise [deg]; a short list repeats");
  v.field("time_us", time_us, "firing time of each beam after its column began [us]; a short list repeats");
  v.field("height_m", height_m, "height of each beam's origin above the sensor's [m]; a short list repeats");
  v.field("lateral_m", lateral_m,
          "each beam's origin is so far to the left of its direction [m]; a short list repeats");
  v.field("origin_radius_m", origin_radius_m, "beams leave so far from the axis of rotation [m]", 0, 1);
  v.field("phase_deg", phase_deg, "azimuth of column 0 in the sensor frame [deg]", -360, 360);
  v.field("column_s", column_s, "time from column to column [s]; 0 = sweep_s / columns", 0, 1);
  v.field("blind_deg", blind_deg, "azimuths without returns: from, to, from, to ... counter-clockwise [deg]");
  v.field("range_quantum_m", range_quantum_m, "ranges are multiples of this [m]; 0 = any", 0, 1);
  v.field("divergence_mrad", divergence_mrad, "full width of a beam at half power [mrad]", 0, 100);
  v.field("pulse_m", pulse_m, "echoes nearer to each other melt into one [m]", 0, 10);
}

void SignalModel::describe(ParamVisitor& v) {
  v.field("gain", gain, "counts times m^2 for a white surface hit at a right angle", 1e-6, 1e12);
  v.field("near_m", near_m, "below this range the receiver sees part of the echo [m]", 0, 100);
  v.field("near_power", near_power, "... by (r / near_m)^near_power", 0, 10);
  v.field("floor", floor, "weaker echoes are never seen [counts]", 0, 1e9);
  v.field("saturation", saturation, "stronger echoes are reported as this [counts]", 1e-6, 1e12);
  v.field("retro_gain", retro_gain, "a traffic sign is so many times as bright as white paint", 0, 1e6);
  v.field("sigma_m", sigma_m, "range noise at range 0, one sigma [m]", 0, 10);
  v.field("sigma_per_m", sigma_per_m, "... more for each metre of range", 0, 1);
  v.field("sigma_signal_m", sigma_signal_m, "... more for weak echoes: times S^-0.63 [m]", 0, 100);
  v.field("dropout_base", dropout_base, "share of echoes lost whatever their strength", 0, 1);
  v.field("dropout_scale", dropout_scale, "... more: dropout_scale (dropout_signal / S)^dropout_power", 0, 1);
  v.field("dropout_signal", dropout_signal, "[counts]", 0, 1e9);
  v.field("dropout_power", dropout_power, "", 0, 10);
  v.field("dropout_most", dropout_most, "at most this share of echoes above the floor is lost", 0, 1);
}

}  // namespace scslam
