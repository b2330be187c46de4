// Oxford Radar RobotCar: radar/<us>.png (oxford_radar.h), gt/radar_odometry.csv. Base is the radar.
#include "scslam/sensor/oxford_radar.h"

#include "scslam/core/error.h"
#include "scslam/sensor/radar_folder.h"
#include "scslam/sensor/scan_files.h"

namespace scslam {
namespace {

namespace fs = std::filesystem;

fs::path imagesOf(const fs::path& uri) { return fs::is_directory(uri / "radar") ? uri / "radar" : uri; }

struct OxfordRadarScans final : ScanFormat {
  struct Params : ParamSetOf<Params> {
    void describe(ParamVisitor&) override {}
  };
  OxfordRadarScans(const Params&, const PluginContext&) {}

  Guess probe(const fs::path& uri) const override {
    const auto files = listFiles(imagesOf(uri), {".png"});
    if (files.empty() || !stampOfName(files.front())) return {};
    return {90, "radar/<time>.png"};
  }

  std::unique_ptr<ScanSource> open(const fs::path& uri, const OpenOptions&) const override {
    RadarFolder folder;
    folder.files = listFiles(imagesOf(uri), {".png"});
    if (folder.files.empty()) throw inputError("{} holds no radar/*.png", uri.string());
    folder.description = fmt::format("Oxford radar, {} sweeps", folder.files.size());
    folder.load = [](const fs::path& file) { return readOxfordRadar(file); };
    return makeRadarSource(std::move(folder));
  }
};

}  // namespace

SCSLAM_REGISTER(ScanFormat, OxfordRadarScans, "oxford_radar", "folder with [radar/]<us>.png of Oxford's layout")

}  // namespace scslam
