// A folder of scan files (PCD, PLY, BIN, XYZ), or one such file. Times from times.txt, timestamps.txt or the names.
#include <algorithm>
#include <array>

#include "scslam/core/error.h"
#include "scslam/sensor/cloud_files.h"
#include "scslam/sensor/folder_source.h"
#include "scslam/sensor/scan_files.h"

namespace scslam {
namespace {

namespace fs = std::filesystem;

/// Where the scans are: `uri` itself or a sub-folder with a usual name.
struct Layout {
  fs::path folder;
  std::vector<fs::path> files;
  std::string found;
};

/// The files of the extension that most have; a .txt is a scan only when its name is a number and nothing else is here.
std::vector<fs::path> scansIn(const fs::path& folder) {
  std::vector<fs::path> best;
  for (const char* extension : {".pcd", ".ply", ".bin", ".xyz"})
    if (auto files = listFiles(folder, {extension}); files.size() > best.size()) best = std::move(files);
  if (!best.empty()) return best;
  auto texts = listFiles(folder, {".txt"});
  std::erase_if(texts, [](const fs::path& file) { return !numberOf(file) && !stampOfName(file); });
  return texts;
}

std::optional<Layout> findLayout(const fs::path& uri) {
  constexpr std::array kUsual = {"", "scans", "Scans", "clouds", "pcd", "lidar", "data", "velodyne_points/data"};
  for (const char* sub : kUsual)
    if (auto files = scansIn(uri / sub); !files.empty())
      return Layout{uri / sub, files, fmt::format("{}{}*{}", sub, *sub != 0 ? "/" : "", files[0].extension().string())};
  return std::nullopt;
}

bool isCloudFile(const fs::path& uri) {
  if (!fs::is_regular_file(uri)) return false;
  constexpr std::array kKnown = {".pcd", ".ply", ".bin", ".xyz"};
  return std::find(kKnown.begin(), kKnown.end(), uri.extension().string()) != kKnown.end();
}

/// Looks beside the scans, above them (they lie in a sub-folder) and where the user pointed.
fs::path beside(const Layout& layout, const fs::path& uri, const char* name) {
  for (const fs::path& folder : {layout.folder, layout.folder / "..", uri})
    if ((folder != layout.folder / ".." || layout.folder != uri / "") && fs::is_regular_file(folder / name))
      return folder / name;
  return {};
}

void addStamps(const Layout& layout, const fs::path& uri, FolderScans& scans) {
  for (const char* name : {"times.txt", "timestamps.txt"})
    if (const fs::path file = beside(layout, uri, name); !file.empty()) {
      scans.stamps = readTimes(file, scans.files);
      scans.description += fmt::format(", {}", name);
      return;
    }
  for (const fs::path& file : scans.files)
    if (const auto stamp = stampOfName(file)) scans.stamps.push_back(*stamp);
  if (scans.stamps.size() == scans.files.size()) {
    scans.description += ", times from the names";
    return;
  }
  scans.stamps = madeUpStamps(scans.files);
  scans.description += ", no times: 10 Hz made up";
}

/// Poses that do not fit are somebody else's: said, not an error.
void addTruth(const Layout& layout, const fs::path& uri, FolderScans& scans) {
  for (const char* name : {"poses_gt.txt", "poses.txt", "gt.tum", "groundtruth.tum", "groundtruth.txt"}) {
    const fs::path file = beside(layout, uri, name);
    if (file.empty()) continue;
    try {
      scans.truth = trajectoryOf(scans.stamps, readPosesOfScans(file, scans.files, scans.stamps));
      if (!scans.truth) throw inputError("{} has no pose at the time of any scan", file.string());
      scans.description += fmt::format(", truth from {}", name);
      return;
    } catch (const Error& error) {
      scans.description += fmt::format(", {} not used ({})", name, error.what());
    }
  }
}

struct CloudsFormat final : ScanFormat {
  struct Params : ParamSetOf<Params> {
    void describe(ParamVisitor&) override {}
  };
  CloudsFormat(const Params&, const PluginContext&) {}

  Guess probe(const fs::path& uri) const override {
    if (isCloudFile(uri)) return {60, "one " + uri.extension().string() + " file"};
    const auto layout = findLayout(uri);
    return layout ? Guess{40, layout->found} : Guess{};
  }

  std::unique_ptr<ScanSource> open(const fs::path& uri, const OpenOptions& options) const override {
    FolderScans scans;
    if (isCloudFile(uri)) {
      scans.files = {uri};
      scans.stamps = {stampOfName(uri).value_or(stampFromSeconds(0))};
      scans.description = "one cloud file";
    } else {
      const auto layout = findLayout(uri);
      if (!layout) throw inputError("{} holds no *.pcd, *.ply, *.bin or *.xyz", uri.string());
      scans.files = layout->files;
      scans.description = fmt::format("{} scans {}", scans.files.size(), layout->found);
      addStamps(*layout, uri, scans);
      addTruth(*layout, uri, scans);
    }
    if (options.sensor) {
      scans.table = options.sensor;
      scans.T_base_sensor = options.sensor->T_base_sensor();
      scans.planar = options.sensor->rings == 1;
    }
    scans.label = "lidar";
    scans.load = readCloudFile;
    return makeFolderSource(std::move(scans));
  }
};

}  // namespace

SCSLAM_REGISTER(ScanFormat, CloudsFormat, "clouds", "folder of *.pcd, *.ply, *.bin or *.xyz scans, or one such file")

}  // namespace scslam
