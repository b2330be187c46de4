// Saved sessions as input: ours (session.yaml) and those of SC-A-LOAM and its relatives: Scans/NNNNNN.pcd,
// odom_poses.txt or optimized_poses.txt (T_odom_sensor, row = keyframe number), times.txt.
#include <yaml-cpp/yaml.h>

#include <algorithm>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/pcd.h"
#include "scslam/sensor/folder_source.h"
#include "scslam/sensor/scan_files.h"

namespace scslam {
namespace {

namespace fs = std::filesystem;

struct Manifest {
  Pose T_base_sensor = Pose::Identity();
  bool planar = false;
  std::string label;
};

Manifest readManifest(const fs::path& file) {
  Manifest manifest;
  try {
    const YAML::Node yaml = YAML::Load(readFile(file, std::size_t{1} << 24));
    if (const auto node = yaml["T_base_sensor"]) {
      const auto numbers = node.as<std::vector<double>>();
      if (numbers.size() != 12)
        throw inputError("{}: T_base_sensor has {} numbers, not 12", file.string(), numbers.size());
      for (int i = 0; i < 12; ++i) manifest.T_base_sensor.matrix()(i / 4, i % 4) = numbers[static_cast<std::size_t>(i)];
      if (!isRigid(manifest.T_base_sensor)) throw inputError("{}: T_base_sensor is no rigid motion", file.string());
    }
    if (const auto node = yaml["planar"]) manifest.planar = node.as<bool>();
    if (const auto node = yaml["sensor_label"]) manifest.label = node.as<std::string>();
  } catch (const YAML::Exception& error) {
    throw inputError("{}:{}:{}: {}", file.string(), error.mark.line + 1, error.mark.column + 1, error.msg);
  }
  return manifest;
}

/// A killed saver leaves more scans than rows: those without a row are left out.
void keepScansWithRows(FolderScans& scans, const fs::path& table, std::size_t rows) {
  const std::size_t before = scans.files.size();
  if (rows >= before) return;
  std::erase_if(scans.files, [rows](const fs::path& file) { return numberOf(file).value_or(rows) >= rows; });
  if (scans.files.empty()) throw inputError("{} has no row for any of the {} scans", table.string(), before);
  scans.description +=
      fmt::format(", {} scans without a row in {} left out", before - scans.files.size(), table.filename().string());
}

fs::path firstThatExists(const fs::path& folder, std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (fs::is_regular_file(folder / name)) return folder / name;
  return {};
}

struct SessionFormat final : ScanFormat {
  struct Params : ParamSetOf<Params> {
    void describe(ParamVisitor&) override {}
  };
  SessionFormat(const Params&, const PluginContext&) {}

  Guess probe(const fs::path& uri) const override {
    if (listFiles(uri / "Scans", {".pcd"}).empty()) return {};
    if (fs::is_regular_file(uri / "session.yaml")) return {100, "session.yaml and Scans/*.pcd"};
    const fs::path poses = firstThatExists(uri, {"odom_poses.txt", "optimized_poses.txt"});
    return poses.empty() ? Guess{} : Guess{95, "Scans/*.pcd and " + poses.filename().string()};
  }

  std::unique_ptr<ScanSource> open(const fs::path& uri, const OpenOptions& options) const override {
    FolderScans scans;
    scans.files = listFiles(uri / "Scans", {".pcd"});
    if (scans.files.empty()) throw inputError("{} holds no Scans/*.pcd", uri.string());
    Manifest manifest;
    const bool ours = fs::is_regular_file(uri / "session.yaml");
    if (ours) manifest = readManifest(uri / "session.yaml");
    scans.T_base_sensor = options.sensor ? options.sensor->T_base_sensor() : manifest.T_base_sensor;
    scans.planar = manifest.planar;
    scans.label = manifest.label.empty() ? "session" : manifest.label;
    scans.deskewed = true;
    scans.load = readPcd;
    const fs::path poses = firstThatExists(uri, {"odom_poses.txt", "optimized_poses.txt"});
    const fs::path times = firstThatExists(uri, {"times.txt"});
    for (const fs::path& table : {poses, times})
      if (!table.empty()) keepScansWithRows(scans, table, readTextTable(table).rows.size());
    scans.stamps = times.empty() ? madeUpStamps(scans.files) : readTimes(times, scans.files);
    if (!poses.empty()) {
      scans.T_odom_base = readPosesOfScans(poses, scans.files, scans.stamps);
      for (auto& T : scans.T_odom_base)
        if (T) T = *T * scans.T_base_sensor.inverse();
    }
    scans.description = fmt::format("{} session, {} scans, poses from {}, {}{}", ours ? "scslam" : "SC-A-LOAM",
                                    scans.files.size(), poses.empty() ? "nowhere" : poses.filename().string(),
                                    times.empty() ? "no times.txt: 10 Hz made up" : "times.txt", scans.description);
    return makeFolderSource(std::move(scans));
  }
};

}  // namespace

SCSLAM_REGISTER(ScanFormat, SessionFormat, "session",
                "saved session: Scans/*.pcd and session.yaml, odom_poses.txt or optimized_poses.txt")

}  // namespace scslam
