// Oxford Radar RobotCar and Boreas: radar/<us>.png (oxford_radar.h) and gt/radar_odometry.csv or
// applanix/radar_poses.csv. Base is the radar. Which bins an image has, it does not say: the layout and, for Boreas,
// the date choose the sensor table.
#include "scslam/sensor/oxford_radar.h"

#include "scslam/core/error.h"
#include "scslam/sensor/radar_folder.h"
#include "scslam/sensor/radar_truth.h"
#include "scslam/sensor/scan_files.h"
#include "scslam/sensor/sensor_tables.h"

namespace scslam {
namespace {

namespace fs = std::filesystem;

constexpr double kBoreasUpgrade = 1632182400;  // [s since 1970]: from then on finer bins

/// The images' folder, the recording's, and the truth where there is one.
struct Layout {
  fs::path images, root, truth;
  bool boreas = false;
};

std::optional<Layout> findLayout(const fs::path& uri) {
  const bool inside = !fs::is_directory(uri / "radar");
  Layout layout;
  layout.images = inside ? uri : uri / "radar";
  layout.root = inside ? uri / ".." : uri;
  const auto files = listFiles(layout.images, {".png"});
  if (files.empty() || !stampOfName(files.front())) return std::nullopt;
  layout.boreas = fs::is_directory(layout.root / "applanix") || fs::is_directory(layout.root / "calib") ||
                  fs::weakly_canonical(layout.root).filename().string().starts_with("boreas");
  const fs::path truth = layout.boreas ? "applanix/radar_poses.csv" : "gt/radar_odometry.csv";
  if (fs::is_regular_file(layout.root / truth)) layout.truth = layout.root / truth;
  return layout;
}

SensorModel tableOf(const Layout& layout, const fs::path& first_image) {
  if (!layout.boreas) return loadSensorModel("navtech_cts350x");
  const bool upgraded = *stampOfName(first_image) >= stampFromSeconds(kBoreasUpgrade);
  return loadSensorModel(upgraded ? "navtech_cir304h" : "navtech_cir204h");
}

struct OxfordRadarScans final : ScanFormat {
  struct Params : ParamSetOf<Params> {
    void describe(ParamVisitor&) override {}
  };
  OxfordRadarScans(const Params&, const PluginContext&) {}

  Guess probe(const fs::path& uri) const override {
    const auto layout = findLayout(uri);
    if (!layout) return {};
    return {layout->truth.empty() ? 70 : 90, layout->truth.empty() ? "radar/<time>.png" : "radar/<time>.png and truth",
            true};
  }

  std::unique_ptr<ScanSource> open(const fs::path& uri, const OpenOptions& options) const override {
    const auto layout = findLayout(uri);
    if (!layout) throw inputError("{} holds no [radar/]<time>.png", uri.string());
    RadarFolder folder;
    folder.files = listFiles(layout->images, {".png"});
    const SensorModel table = options.sensor ? *options.sensor : tableOf(*layout, folder.files.front());
    OxfordRadarFormat format;
    format.validity = table.radar.validity;
    format.T_base_sensor = table.T_base_sensor();
    folder.description = fmt::format("{} radar, {} sweeps, bins of {} m and offset {} m assumed ({})",
                                     layout->boreas ? "Boreas" : "Oxford", folder.files.size(),
                                     table.radar.range_resolution_m, table.radar.range_offset_m, table.name);
    if (!layout->truth.empty()) readTruth(*layout, folder);
    folder.load = [format, table = table.radar](const fs::path& file) {
      RadarScan sweep = readOxfordRadar(file, format);
      applyTable(table, sweep);
      return sweep;
    };
    return makeRadarSource(std::move(folder));
  }

 private:
  static void readTruth(const Layout& layout, RadarFolder& folder) {
    std::size_t broken_at = 0;
    folder.truth = layout.boreas ? readBoreasTruth(layout.truth) : readOxfordTruth(layout.truth, broken_at);
    folder.description += ", truth from " + layout.truth.filename().string();
    if (broken_at != 0) folder.description += fmt::format(" up to line {}, where it breaks off", broken_at);
  }
};

}  // namespace

SCSLAM_REGISTER(ScanFormat, OxfordRadarScans, "oxford_radar", "Oxford and Boreas: folder with [radar/]<us>.png")

}  // namespace scslam
