// A 2-D occupancy grid: grid.png (black = occupied, white = free, grey = unknown), world file and ROS map. From each
// keyframe the plane is free as far as the nearest obstacle in each direction; obstacles are the points of a band of
// heights around the sensor (planar scans: all). Log-odds as in H. P. Moravec, A. Elfes, ICRA 1985.
#include <algorithm>
#include <cmath>
#include <limits>

#include "scslam/mapping/map_exporter.h"
#include "scslam/mapping/raster_map.h"

namespace scslam {
namespace {

constexpr double kDefaultCell = 0.2;  // [m]

class GridExporter final : public MapExporter {
 public:
  struct Params : ParamSetOf<Params> {
    double low_m = -1.2, high_m = 0.5, max_range_m = 80;
    int directions = 720;
    double hit = 0.85, miss = 0.4, most = 3.5;
    void describe(ParamVisitor& v) override {
      v.field("low_m", low_m, "obstacles begin at this height above the sensor; planar scans: no matter [m]", -1000,
              1000);
      v.field("high_m", high_m, "and end at this one [m]", -1000, 1000);
      v.field("max_range_m", max_range_m, "what lies farther from the sensor is not drawn [m]", 1, 10'000);
      v.field("directions", directions, "into so many the full turn is cut", 8, 100'000);
      v.field("hit", hit, "log-odds a keyframe adds to a cell with an obstacle", 0, 100);
      v.field("miss", miss, "and takes from a free one", 0, 100);
      v.field("most", most, "log-odds stay within plus and minus this", 0.1, 100);
    }
  };
  GridExporter(const Params& params, const PluginContext&) : params_(params) {}

  Tiles tiles() const override { return Tiles::kEveryPoint; }
  void begin(const MapInfo& info) override {
    folder_ = info.folder, planar_ = info.planar, offset_m_ = info.offset_m;
    cell_m_ = info.voxel_m > 0 ? info.voxel_m : kDefaultCell;
  }

  void add(const MapTile& tile) override {
    const Eigen::Vector2d origin = tile.sensor_origin.head<2>();
    constexpr double kReach = 1e9;  // cells still have numbers there
    if (!(origin.cwiseAbs().maxCoeff() / cell_m_ < kReach))
      throw inputError("a keyframe lies {:.3g} m from the map's origin, too far for a grid of {} m",
                       origin.cwiseAbs().maxCoeff(), cell_m_);
    const std::vector<std::pair<int, int>> obstacles = obstaclesOf(tile);
    drawFree(origin);
    for (const auto& [i, j] : obstacles) raise(i, j, params_.hit + params_.miss);  // its ray has just lowered it
  }

  std::vector<std::filesystem::path> end() override {
    RasterFrame frame;
    frame.cell_m = cell_m_, frame.offset_m = offset_m_;
    grid_.forEach([&](int i, int j, float odds) {
      if (odds != 0) frame.include(i, j);
    });
    if (frame.empty())
      throw inputError("no keyframe shows an obstacle between {} and {} m", params_.low_m, params_.high_m);
    constexpr std::uint8_t kUnknown = 205, kFree = 254;
    GreyImage picture = frame.picture(kUnknown);
    grid_.forEach([&](int i, int j, float odds) {
      if (odds == 0) return;
      const double occupied = 1 / (1 + std::exp(-static_cast<double>(odds)));
      picture.pixels[frame.pixel(i, j)] = static_cast<std::uint8_t>(std::lround(kFree * (1 - occupied)));
    });
    return writeRasterMap(folder_, "grid", picture, frame, {});
  }

 private:
  int cellOf(double metres) const { return static_cast<int>(std::floor(metres / cell_m_)); }

  void raise(int i, int j, double by) {
    float& odds = grid_.at(i, j);
    odds = static_cast<float>(std::clamp(static_cast<double>(odds) + by, -params_.most, params_.most));
  }

  /// Cells with an obstacle, each once, in order; nearest_ becomes the range of the first one in each direction.
  std::vector<std::pair<int, int>> obstaclesOf(const MapTile& tile) {
    const auto n = static_cast<std::size_t>(params_.directions);
    nearest_.assign(n, std::numeric_limits<double>::infinity());
    std::vector<std::pair<int, int>> cells;
    for (std::size_t k = 0; k < tile.cloud_map.size(); ++k) {
      const Eigen::Vector3d p = tile.cloud_map.point(k).cast<double>(), d = p - tile.sensor_origin;
      const double range = d.head<2>().norm();
      const bool in_band = planar_ || (d.z() >= params_.low_m && d.z() <= params_.high_m);
      if (!in_band || !(range <= params_.max_range_m)) continue;
      const double turn = (std::atan2(d.y(), d.x()) + M_PI) / (2 * M_PI);
      double& nearest = nearest_[std::min(n - 1, static_cast<std::size_t>(turn * static_cast<double>(n)))];
      nearest = std::min(nearest, range);
      cells.emplace_back(cellOf(p.x()), cellOf(p.y()));
    }
    std::sort(cells.begin(), cells.end());
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
    return cells;
  }

  /// Each cell that a ray of this keyframe passes, once.
  void drawFree(const Eigen::Vector2d& origin) {
    std::vector<std::pair<int, int>> passed;
    for (std::size_t k = 0; k < nearest_.size(); ++k) {
      if (!std::isfinite(nearest_[k])) continue;  // nothing came back: nothing is known
      const double angle = 2 * M_PI * (static_cast<double>(k) + 0.5) / static_cast<double>(nearest_.size()) - M_PI;
      const double step = 0.7 * cell_m_;
      for (double r = 0; r <= nearest_[k]; r += step)
        passed.emplace_back(cellOf(origin.x() + r * std::cos(angle)), cellOf(origin.y() + r * std::sin(angle)));
      passed.emplace_back(cellOf(origin.x() + nearest_[k] * std::cos(angle)),
                          cellOf(origin.y() + nearest_[k] * std::sin(angle)));
    }
    std::sort(passed.begin(), passed.end());
    passed.erase(std::unique(passed.begin(), passed.end()), passed.end());
    for (const auto& [i, j] : passed) raise(i, j, -params_.miss);
  }

  Params params_;
  Eigen::Vector3d offset_m_;
  std::filesystem::path folder_;
  bool planar_ = false;
  double cell_m_ = kDefaultCell;
  std::vector<double> nearest_;
  TiledGrid<float> grid_;
};

}  // namespace

SCSLAM_REGISTER(MapExporter, GridExporter, "grid", "2-D occupancy as PNG, world file and ROS map")

}  // namespace scslam
