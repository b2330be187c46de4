#include "scslam/sensor/radar_table.h"

namespace scslam {

void RadarTable::describe(ParamVisitor& v) {
  v.field("range_resolution_m", range_resolution_m, "width of a range bin; 0: no radar, or as recorded [m]", 0, 100);
  v.field("range_offset_m", range_offset_m, "what must be added to a bin's nominal range [m]", -1000, 1000);
  v.field("doppler_beta_s", doppler_beta_s, "range error by range rate: approaching looks nearer; 0: none [s]", -10,
          10);
  v.field("first_azimuth_deg", first_azimuth_deg,
          "where the first row of an image without encoder looks, clockwise from the x axis [deg]", -360, 360);
  v.field("stamp", stamp, "which azimuth the one stamp of an image belongs to", {"start", "middle", "end"});
  v.field("validity", validity, "byte 10 of a row in Oxford's layout says whether it was measured");
}

void applyTable(const RadarTable& table, RadarScan& sweep) {
  if (!(table.range_resolution_m > 0)) return;
  sweep.range_resolution_m = table.range_resolution_m;
  sweep.range_offset_m = table.range_offset_m;
  sweep.doppler_beta_s = table.doppler_beta_s;
}

}  // namespace scslam
