// MulRan's radar: [sensor_data/]radar/polar_oxford_form/<ns>.png (Oxford's layout, stamps in ns) or, without stamps and
// encoder, polar/<ns>.png (azimuths as columns), and global_pose.csv. An image's name is the end of its sweep. Base is
// the car body.
#include "scslam/core/error.h"
#include "scslam/sensor/mulran_poses.h"
#include "scslam/sensor/oxford_radar.h"
#include "scslam/sensor/radar_folder.h"
#include "scslam/sensor/radar_picture.h"
#include "scslam/sensor/scan_files.h"
#include "scslam/sensor/sensor_tables.h"

namespace scslam {
namespace {

namespace fs = std::filesystem;

struct Layout {
  fs::path images, poses;
  bool oxford_form = false;
  std::string found;
};

std::optional<Layout> layoutAt(const fs::path& images, const fs::path& root) {
  const std::string form = images.filename().string();
  if (form != "polar" && form != "polar_oxford_form") return std::nullopt;
  const auto files = listFiles(images, {".png"});
  if (files.empty() || !stampOfName(files.front())) return std::nullopt;
  Layout layout{images, findMulranPoses(root), form == "polar_oxford_form", form + "/<ns>.png"};
  if (!layout.poses.empty()) layout.found += " and global_pose.csv";
  return layout;
}

std::optional<Layout> findLayout(const fs::path& uri) {
  for (const char* form : {"polar_oxford_form", "polar"})
    for (const char* sub : {"sensor_data/radar", "radar", ""})
      if (auto layout = layoutAt(uri / sub / form, uri)) return layout;
  const fs::path whole = fs::weakly_canonical(uri);
  fs::path root = whole.parent_path();  // the folder of images itself, in radar/ or sensor_data/radar/
  for (const char* level : {"radar", "sensor_data"})
    if (root.filename() == level) root = root.parent_path();
  return layoutAt(whole, root);
}

/// Rows that all have one stamp have that of the image.
void spreadOneStamp(RadarScan& sweep, const fs::path& file, const SensorModel& table) {
  if (!sweep.stamps.empty() && sweep.stamps.front() == sweep.stamps.back()) stampRows(sweep, *stampOfName(file), table);
}

struct MulranRadar final : ScanFormat {
  struct Params : ParamSetOf<Params> {
    void describe(ParamVisitor&) override {}
  };
  MulranRadar(const Params&, const PluginContext&) {}

  Guess probe(const fs::path& uri) const override {
    const auto layout = findLayout(uri);
    return layout ? Guess{80, layout->found, true} : Guess{};
  }

  std::unique_ptr<ScanSource> open(const fs::path& uri, const OpenOptions& options) const override {
    const auto layout = findLayout(uri);
    if (!layout) throw inputError("{} holds neither polar_oxford_form/<ns>.png nor polar/<ns>.png", uri.string());
    const SensorModel table = options.sensor ? *options.sensor : loadSensorModel("navtech_mulran");
    RadarFolder folder;
    folder.files = listFiles(layout->images, {".png"});
    for (const fs::path& file : folder.files)
      if (!stampOfName(file)) throw inputError("{}: the name is not a time in nanoseconds", file.string());
    folder.description = fmt::format("MulRan radar, {} sweeps of {}, bins of {} m and offset {} m assumed ({})",
                                     folder.files.size(), layout->images.filename().string(),
                                     table.radar.range_resolution_m, table.radar.range_offset_m, table.name);
    if (!layout->poses.empty()) {
      std::string truth;
      folder.truth = readMulranPoses(layout->poses, truth);
      folder.description += ", " + truth;
    }
    folder.load = [table, oxford_form = layout->oxford_form](const fs::path& file) {
      if (!oxford_form) return readRadarPicture(file, *stampOfName(file), table);
      OxfordRadarFormat format;
      format.validity = table.radar.validity;
      format.T_base_sensor = table.T_base_sensor();
      RadarScan sweep = readOxfordRadar(file, format);
      spreadOneStamp(sweep, file, table);
      applyTable(table.radar, sweep);
      return sweep;
    };
    return makeRadarSource(std::move(folder));
  }
};

}  // namespace

SCSLAM_REGISTER(ScanFormat, MulranRadar, "mulran_radar",
                "folder with [sensor_data/radar/]polar_oxford_form/*.png or polar/*.png")

}  // namespace scslam
