// Accumulated radar power: the mean of all sweeps' power over the plane, each azimuth from where the radar was when it
// looked there, ranges corrected for the Doppler shift of its own motion. radar_power.png (white = strong), world file,
// ROS map.
#include <algorithm>
#include <cmath>

#include "scslam/core/parallel.h"
#include "scslam/mapping/radar_sweeps.h"
#include "scslam/mapping/raster_map.h"

namespace scslam {
namespace {

constexpr double kDefaultCell = 0.25;  // [m]

struct Mean {
  std::uint32_t sum = 0, count = 0;
};

/// Power of one sweep anywhere in the plane.
class SweepField {
 public:
  SweepField(const RadarSweeps::Sweep& sweep, double cell_m)
      : image_(*sweep.image), poses_(sweep.poses), cell_m_(cell_m), beta_(sweep.image->doppler_beta_s) {
    sums_.resize(image_.azimuths * (image_.bins + 1));
    for (std::size_t a = 0; a < image_.azimuths; ++a) {
      std::uint32_t* sums = &sums_[a * (image_.bins + 1)];
      for (std::size_t i = 0; i < image_.bins; ++i) sums[i + 1] = sums[i] + image_.row(a)[i];
    }
    // Encoders turn evenly: row = (angle - first) / step, either way round.
    const double quarter = std::remainder(image_.angles[image_.azimuths / 4] - image_.angles[0], 2 * M_PI);
    rows_per_rad_ = static_cast<double>(image_.azimuths) / (quarter < 0 ? -2 * M_PI : 2 * M_PI);
  }

  /// Mean power over a cell around (x, y) of the map, negative where the sweep has none.
  double at(double x, double y) const {
    // The azimuth that looked there depends on the pose, which depends on the azimuth: two rounds settle it.
    std::size_t azimuth = image_.azimuths / 2;
    double row = 0, range = 0;
    for (int round = 0; round < 2; ++round) {
      const AzimuthPose& pose = poses_[azimuth];
      if (!pose.known) return -1;
      const double dx = x - pose.x, dy = y - pose.y;
      const double bearing = pose.yaw - std::atan2(dy, dx);  // clockwise from the sensor's x
      row = rowOf(bearing);
      azimuth = static_cast<std::size_t>(row);
      range = std::hypot(dx, dy);
      range -= range > 0 ? beta_ * (pose.vx * dx + pose.vy * dy) / range : 0;  // approaching looks nearer
    }
    const std::size_t next = (azimuth + 1) % image_.azimuths;
    const double share = row - std::floor(row), a = along(azimuth, range), b = along(next, range);
    if (a < 0 || b < 0) return std::max(a, b);
    return (1 - share) * a + share * b;
  }

 private:
  double rowOf(double bearing) const {
    const auto n = static_cast<double>(image_.azimuths);
    const double rows = (bearing - image_.angles[0]) * rows_per_rad_;
    return std::clamp(rows - n * std::floor(rows / n), 0.0, std::nextafter(n, 0.0));
  }
  /// Mean over the bins within half a cell.
  double along(std::size_t azimuth, double range) const {
    if (!poses_[azimuth].known) return -1;
    const double middle = (range - image_.range_offset_m) / image_.range_resolution_m;
    const double half = std::max(0.5, 0.5 * cell_m_ / image_.range_resolution_m);
    if (middle - half < 0 || middle + half > static_cast<double>(image_.bins)) return -1;
    const auto begin = static_cast<std::size_t>(middle - half), end = static_cast<std::size_t>(middle + half);
    const std::uint32_t* sums = &sums_[azimuth * (image_.bins + 1)];
    return static_cast<double>(sums[end] - sums[begin]) / static_cast<double>(end - begin);
  }

  const RadarScan& image_;
  const std::vector<AzimuthPose>& poses_;
  double cell_m_, beta_, rows_per_rad_ = 0;
  std::vector<std::uint32_t> sums_;  ///< per row, of the first i bins
};

class RadarPowerExporter final : public MapExporter {
 public:
  struct Params : ParamSetOf<Params> {
    double max_range_m = 120, min_range_m = 3;
    void describe(ParamVisitor& v) override {
      v.field("min_range_m", min_range_m, "nearer power is not drawn [m]", 0, 1000);
      v.field("max_range_m", max_range_m, "nor is farther [m]", 1, 10'000);
    }
  };
  RadarPowerExporter(const Params& params, const PluginContext& context) : params_(params), context_(context) {}

  Tiles tiles() const override { return Tiles::kNone; }
  void begin(const MapInfo& info) override {
    folder_ = info.folder, offset_m_ = info.offset_m;
    cell_m_ = info.voxel_m > 0 ? info.voxel_m : kDefaultCell;
    params_.min_range_m = std::max(params_.min_range_m, info.min_range_m);
    params_.max_range_m = std::min(params_.max_range_m, info.max_range_m);
    sweeps_ = std::make_unique<RadarSweeps>(info, context_);
  }
  void add(const MapTile&) override {}

  std::vector<std::filesystem::path> end() override {
    while (const auto sweep = sweeps_->next()) accumulate(*sweep);
    RasterFrame frame;
    frame.cell_m = cell_m_, frame.offset_m = offset_m_;
    double brightest = 1;
    grid_.forEach([&](int i, int j, const Mean& cell) {
      if (cell.count == 0) return;
      frame.include(i, j);
      brightest = std::max(brightest, meanOf(cell));
    });
    if (frame.empty()) throw inputError("no sweep of the session's input lies on its trajectory");
    GreyImage picture = frame.picture(0);
    grid_.forEach([&](int i, int j, const Mean& cell) {
      if (cell.count == 0) return;
      picture.pixels[frame.pixel(i, j)] = static_cast<std::uint8_t>(std::lround(255 * meanOf(cell) / brightest));
    });
    return writeRasterMap(folder_, "radar_power", picture, frame, {"scale", true, 0.35, 0.12});
  }

 private:
  static constexpr double kSubLevels = 16;  // of the sums: means are finer than a grey level
  static double meanOf(const Mean& cell) {
    return static_cast<double>(cell.sum) / (kSubLevels * static_cast<double>(cell.count));
  }

  void accumulate(const RadarSweeps::Sweep& sweep) {
    const RadarScan& image = *sweep.image;
    const auto known = std::find_if(sweep.poses.begin(), sweep.poses.end(), [](const auto& p) { return p.known; });
    if (known == sweep.poses.end() || image.azimuths < 8 || image.bins < 8) return;
    const SweepField field(sweep, cell_m_);
    const double reach = std::min(params_.max_range_m, image.rangeAt(static_cast<double>(image.bins)));
    const auto cellOf = [this](double metres) { return static_cast<int>(std::floor(metres / cell_m_)); };
    const int i0 = cellOf(known->x - reach), i1 = cellOf(known->x + reach), j0 = cellOf(known->y - reach),
              j1 = cellOf(known->y + reach);
    for (int j = j0; j <= j1 + TiledGrid<Mean>::kSide;
         j += TiledGrid<Mean>::kSide)  // the map of tiles is not for threads
      for (int i = i0; i <= i1 + TiledGrid<Mean>::kSide; i += TiledGrid<Mean>::kSide) grid_.tile(i, j);
    constexpr std::size_t kRowsPerChunk = 16;
    context_.threads.forEachChunk(static_cast<std::size_t>(j1 - j0 + 1), kRowsPerChunk,
                                  [&](std::size_t begin, std::size_t end, std::size_t) {
                                    for (std::size_t row = begin; row < end; ++row)
                                      drawRow(field, *known, j0 + static_cast<int>(row), i0, i1, reach);
                                  });
  }

  void drawRow(const SweepField& field, const AzimuthPose& pose, int j, int i0, int i1, double reach) {
    const double y = (j + 0.5) * cell_m_;
    for (int i = i0; i <= i1; ++i) {
      const double x = (i + 0.5) * cell_m_, distance = std::hypot(x - pose.x, y - pose.y);
      if (distance < params_.min_range_m || distance > reach) continue;
      const double power = field.at(x, y);
      if (power < 0) continue;
      Mean& cell = grid_.at(i, j);
      cell.sum += static_cast<std::uint32_t>(std::lround(kSubLevels * power)), ++cell.count;
    }
  }

  Params params_;
  PluginContext context_;
  Eigen::Vector3d offset_m_;
  std::filesystem::path folder_;
  double cell_m_ = kDefaultCell;
  std::unique_ptr<RadarSweeps> sweeps_;
  TiledGrid<Mean> grid_;
};

}  // namespace

SCSLAM_REGISTER(MapExporter, RadarPowerExporter, "radar_power", "mean radar power as PNG, world file and ROS map")

}  // namespace scslam
