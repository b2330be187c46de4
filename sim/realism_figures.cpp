#include "sim/realism_figures.h"

namespace scslam::sim {

void RealismFigures::describe(ParamVisitor& v) {
  v.field("scans", scans, "scans measured");
  v.field("elevation_off_deg", elevation_off_deg, "largest distance of a ring's median elevation from the table [deg]");
  v.field("on_ring_share", on_ring_share, "returns that belong to a ring of the table");
  v.field("azimuth_off_step", azimuth_off_step, "median distance from the azimuth grid [steps]; 0.25 = no grid");
  v.field("azimuth_drift_step", azimuth_drift_step, "largest change of a ring's azimuth phase between scans [steps]");
  v.field("range_quantum_m", range_quantum_m, "ranges are multiples of this [m]; 0 = of nothing");
  v.field("column_time_s", column_time_s, "time from a column to the next of higher azimuth [s]; < 0 = clockwise");
  v.field("points", points, "returns a scan");
  v.field("return_rate", return_rate, "returns / (rings x columns)");
  v.field("return_rate_min", return_rate_min, "of the scan with the fewest returns");
  v.field("return_rate_max", return_rate_max, "of the scan with the most returns");
  v.field("blind_columns_share", blind_columns_share, "columns without any return");
  v.field("columns_never_seen", columns_never_seen, "columns without any return in the whole set");
  v.field("low_ring_columns_never_seen", low_ring_columns_never_seen, "the same within the lowest 20 rings");
  v.field("ring_rate", ring_rate, "returns / columns, per ring from the lowest");
  v.field("ring_never_seen", ring_never_seen, "columns without any return in the whole set, per ring");
  v.field("ring_rate_seen", ring_rate_seen, "return rate over the pixels ever seen, per ring");
  v.field("range_histogram", range_histogram, "share of returns from 0, 5, 10, 15, 20, 30, 40, 60, 80, 120 m");
  v.field("range_percentiles_m", range_percentiles_m, "5, 25, 50, 75, 95 % of the ranges [m]");
  v.field("range_noise_m", range_noise_m, "sigma of the range at 2-5-10-15-20-30-40-60-90 m [m]");
  v.field("dropout", dropout, "isolated drop-outs / pixels whose two azimuth neighbours agree");
  v.field("dropout_by_range", dropout_by_range, "the same at 2-20-50-120 m");
  v.field("dropout_by_signal", dropout_by_signal,
          "the same at signals of 0-6-8-10-12-15-20-30-50-80-120-200-400 counts (mean of the neighbours)");
  v.field("jump", jump, "azimuth steps with a range jump above 0.5 m");
  v.field("mixed_pixels_per_jump", mixed_pixels_per_jump,
          "returns between both sides of a jump above 1 m / such jumps");
  v.field("mixed_pixels", mixed_pixels, "returns between both sides of a jump above 1 m / returns");
  v.field("ground_height_m", ground_height_m, "most frequent height at 4-20 m, below -0.8 m [m]");
  v.field("ground_share", ground_share, "returns within 0.35 m of the ground height at 4-25 m");
  v.field("ground_cells", ground_cells, "ground cells of 2 m that hold a plane");
  v.field("ground_plane_std_m", ground_plane_std_m, "standard deviation from the cell's plane, median over cells [m]");
  v.field("ground_plane_std_quartiles_m", ground_plane_std_quartiles_m, "its quartiles over cells [m]");
  v.field("ground_plane_mad_m", ground_plane_mad_m, "the same without outliers: 1.4826 MAD [m]");
  v.field("ground_slope_deg", ground_slope_deg, "slope of the cells' planes, median [deg]");
  v.field("spacing_m", spacing_m, "distance to the nearest other return at 2-10-20-40-80 m [m]");
  v.field("spacing_per_azimuth_step", spacing_per_azimuth_step, "that distance / (range x azimuth step)");
  v.field("voxels", voxels, "voxels of 0.2 m with a return within 40 m");
  v.field("sparse_share", sparse_share, "of these, with fewer than 8 in 1 m radius");
  v.field("linear_planar_scatter", linear_planar_scatter, "the others by the shape of their neighbourhood");
  v.field("planar_vertical_horizontal", planar_vertical_horizontal, "planar ones that are walls, that are level");
  v.field("sc_occupancy", sc_occupancy, "bins of Scan Context (20 x 60, 80 m) with a return");
  v.field("sc_ring_occupancy", sc_ring_occupancy, "the same per ring of 4 m");
  v.field("sc_height_m", sc_height_m, "mean height of the filled bins over 2 m below the sensor [m]");
  v.field("height_percentiles_m", height_percentiles_m, "5, 50, 95 % of the heights [m]");
}

namespace {

using OnNumber = std::function<void(const std::string& key, double&)>;
using OnList = std::function<void(const std::string& key, std::vector<double>&)>;

class FigureVisitor : public ParamVisitor {
 public:
  FigureVisitor(const OnNumber& number, const OnList& list) : number_(number), list_(list) {}
  void field(const char* key, double& value, const char*, double, double) override { number_(key, value); }
  void field(const char* key, std::vector<double>& values, const char*) override { list_(key, values); }
  void field(const char*, int&, const char*, int, int) override {}
  void field(const char*, bool&, const char*) override {}
  void field(const char*, std::string&, const char*, const std::vector<std::string>&) override {}
  void field(const char*, std::vector<std::string>&, const char*, const std::vector<std::string>&) override {}
  void group(const char*, ParamSet&, const char*) override {}

 private:
  const OnNumber& number_;
  const OnList& list_;
};

}  // namespace

void visitFigures(RealismFigures& figures, const OnNumber& number, const OnList& list) {
  FigureVisitor visitor(number, list);
  figures.describe(visitor);
}

std::vector<NamedFigure> namedFigures(const RealismFigures& figures) {
  std::vector<NamedFigure> all;
  RealismFigures copy = figures;
  visitFigures(
      copy,
      [&](const std::string& key, double& value) {
        all.push_back({key, false, {value}});
      },
      [&](const std::string& key, std::vector<double>& values) {
        all.push_back({key, true, values});
      });
  return all;
}

RealismFigures medianOf(const std::vector<RealismFigures>& scans) {
  std::vector<std::vector<NamedFigure>> all;
  for (const RealismFigures& scan : scans) all.push_back(namedFigures(scan));
  std::size_t figure = 0;
  const auto medianAt = [&](std::size_t i) {
    std::vector<double> values;
    for (const auto& scan : all)
      if (i < scan[figure].values.size()) values.push_back(scan[figure].values[i]);
    return median(std::move(values));
  };
  RealismFigures result;
  visitFigures(
      result, [&](const std::string&, double& value) { value = medianAt(0), ++figure; },
      [&](const std::string&, std::vector<double>& values) {
        for (const auto& scan : all) values.resize(std::max(values.size(), scan[figure].values.size()));
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = medianAt(i);
        ++figure;
      });
  result.scans = static_cast<int>(scans.size());
  return result;
}

}  // namespace scslam::sim
