#include "sim/realism_target.h"

#include <map>
#include <sstream>

#include "scslam/core/error.h"

namespace scslam::sim {

void GridTolerance::describe(ParamVisitor& v) {
  v.field("elevation_deg", elevation_deg, "distance of a ring's median elevation from the table [deg]; 0 = unchecked",
          0.0, 10.0);
  v.field("azimuth_step", azimuth_step, "distance from the azimuth grid, drift of its phase [steps]; 0 = unchecked",
          0.0, 0.5);
  v.field("range_quantum_m", range_quantum_m, "ranges are multiples of this [m]; 0 = unchecked", 0.0, 1.0);
  v.field("column_time", column_time, "relative error of the time a column; 0 = unchecked", 0.0, 1.0);
}

void RealismTarget::describe(ParamVisitor& v) {
  v.field("name", name, "what it is, for messages");
  v.field("about", about, "where the scans come from");
  v.group("sensor", sensor, "the table it was measured with");
  v.group("grid", grid, "what of the sensor's grid is kept, and how exactly");
  v.group("figures", figures, "as measured; -1 in a list = not measured");
}

namespace {

/// Heights may be negative; every other number of a list is a share or a length.
bool mayBeNegative(const std::string& key) { return key == "height_percentiles_m"; }

std::size_t lengthOf(const std::string& key, const SensorModel& sensor) {
  static const std::map<std::string, std::size_t> lengths = {
      {"range_histogram", kRangeHistogram_m.size()},
      {"range_percentiles_m", 5},
      {"range_noise_m", kNoiseBins_m.size() - 1},
      {"dropout_by_range", kDropoutBins_m.size() - 1},
      {"dropout_by_signal", kSignalBins.size() - 1},
      {"ground_plane_std_quartiles_m", 2},
      {"spacing_m", kSpacingBins_m.size() - 1},
      {"linear_planar_scatter", 3},
      {"planar_vertical_horizontal", 2},
      {"sc_ring_occupancy", 20},
      {"height_percentiles_m", 3},
  };
  const auto it = lengths.find(key);
  return it != lengths.end() ? it->second : static_cast<std::size_t>(sensor.rings);  // the others are one a ring
}

double rounded(double value) { return measured(value) ? std::stod(fmt::format("{:.5g}", value)) : value; }

}  // namespace

RealismTarget loadRealismTarget(const std::string& text, const std::string& source) {
  RealismTarget target;
  loadYaml(target, text, source);
  if (target.sensor.elevation_deg.size() != static_cast<std::size_t>(target.sensor.rings))
    throw usageError("{}: sensor.elevation_deg has {} entries for {} rings", source, target.sensor.elevation_deg.size(),
                     target.sensor.rings);
  visitFigures(
      target.figures, [](const std::string&, double&) {},
      [&](const std::string& key, std::vector<double>& values) {
        const std::size_t length = lengthOf(key, target.sensor);
        if (!values.empty() && values.size() != length)
          throw usageError("{}: figures.{} has {} entries instead of {}", source, key, values.size(), length);
        if (mayBeNegative(key)) return;
        for (double& value : values) value = value < 0 ? kNotMeasured : value;
      });
  return target;
}

std::string targetYaml(const RealismTarget& target) {
  RealismTarget copy = target;
  visitFigures(
      copy.figures, [](const std::string&, double& value) { value = rounded(value); },
      [](const std::string&, std::vector<double>& values) {
        for (double& value : values) value = measured(value) ? rounded(value) : -1;
      });
  std::istringstream lines(dumpYaml(copy));
  std::string text;
  for (std::string line; std::getline(lines, line);)
    if (!line.ends_with(": nan")) text += line + "\n";
  return text;
}

}  // namespace scslam::sim
