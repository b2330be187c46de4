// MulRan: [sensor_data/]Ouster/<ns>.bin (float32 x y z intensity, firing by firing, zeros where nothing came back) and
// global_pose.csv (ns, 3x4 of the car body in UTM). Base is the car body; the LiDAR looks backwards (sensor table).
#include "scslam/core/error.h"
#include "scslam/sensor/cloud_files.h"
#include "scslam/sensor/folder_source.h"
#include "scslam/sensor/mulran_poses.h"
#include "scslam/sensor/scan_files.h"
#include "scslam/sensor/sensor_tables.h"

namespace scslam {
namespace {

namespace fs = std::filesystem;

/// The scans' folder, and global_pose.csv where there is one.
struct Layout {
  fs::path scans, poses;
  std::string found;
};

std::optional<Layout> findLayout(const fs::path& uri) {
  for (const char* sub : {"Ouster", "sensor_data/Ouster"}) {
    if (listFiles(uri / sub, {".bin"}).empty()) continue;
    Layout layout{uri / sub, {}, std::string(sub) + "/*.bin"};
    layout.poses = findMulranPoses(uri);
    if (!layout.poses.empty()) layout.found += " and global_pose.csv";
    return layout;
  }
  return std::nullopt;
}

struct MulranFormat final : ScanFormat {
  struct Params : ParamSetOf<Params> {
    void describe(ParamVisitor&) override {}
  };
  MulranFormat(const Params&, const PluginContext&) {}

  Guess probe(const fs::path& uri) const override {
    const auto layout = findLayout(uri);
    return layout ? Guess{layout->poses.empty() ? 85 : 95, layout->found} : Guess{};
  }

  std::unique_ptr<ScanSource> open(const fs::path& uri, const OpenOptions& options) const override {
    const auto layout = findLayout(uri);
    if (!layout) throw inputError("{} holds neither Ouster/*.bin nor sensor_data/Ouster/*.bin", uri.string());
    FolderScans scans;
    scans.files = listFiles(layout->scans, {".bin"});
    for (const fs::path& file : scans.files) {
      const auto stamp = stampOfName(file);
      if (!stamp) throw inputError("{}: the name is not a time in nanoseconds", file.string());
      scans.stamps.push_back(*stamp);
    }
    scans.table = options.sensor ? *options.sensor : loadSensorModel("mulran_os1-64");
    scans.T_base_sensor = scans.table->T_base_sensor();
    scans.description =
        fmt::format("MulRan, {} scans, ring = k mod {} and time by column where a scan is complete ({})",
                    scans.files.size(), scans.table->rings, scans.table->name);
    if (!layout->poses.empty()) {
      std::string truth;
      scans.truth = readMulranPoses(layout->poses, truth);
      scans.description += ", " + truth;
    }
    scans.label = "Ouster";
    scans.load = readXyziBin;
    return makeFolderSource(std::move(scans));
  }
};

}  // namespace

SCSLAM_REGISTER(ScanFormat, MulranFormat, "mulran", "folder with [sensor_data/]Ouster/*.bin [global_pose.csv]")

}  // namespace scslam
