// RADIATE: Navtech_Polar/<number>.png, azimuths as columns from ahead on clockwise, ranges downwards, and
// Navtech_Polar.txt with "Frame: 000001 Time: 1574859771.744660272" a line, the time of arrival. Base is the radar.
#include <algorithm>
#include <map>

#include "scslam/core/error.h"
#include "scslam/sensor/radar_folder.h"
#include "scslam/sensor/radar_picture.h"
#include "scslam/sensor/scan_files.h"
#include "scslam/sensor/sensor_tables.h"

namespace scslam {
namespace {

namespace fs = std::filesystem;

struct Layout {
  fs::path images, times;
};

std::optional<Layout> findLayout(const fs::path& uri) {
  const fs::path images = uri.filename() == "Navtech_Polar" ? uri : uri / "Navtech_Polar";
  if (listFiles(images, {".png"}).empty()) return std::nullopt;
  for (const fs::path& times : {images / ".." / "Navtech_Polar.txt", images / "Navtech_Polar.txt"})
    if (fs::is_regular_file(times)) return Layout{images, times};
  return Layout{images, {}};
}

/// Stamp by number of the frame.
std::map<std::uint64_t, Stamp> readFrameTimes(const fs::path& file) {
  const TextTable table = readTextTable(file);
  std::map<std::uint64_t, Stamp> times;
  for (const auto& row : table.rows) {
    const auto bad = [&] {
      return inputError("{}:{}: not 'Frame: <number> Time: <seconds>'", file.string(), row.line);
    };
    if (row.cells.size() != 4 || row.cells[0] != "Frame:" || row.cells[2] != "Time:") throw bad();
    const auto number = numberOf(row.cells[1]);
    Stamp stamp;
    if (!number || !parseStamp(row.cells[3], stamp)) throw bad();
    times[*number] = stamp;
  }
  return times;
}

struct RadiateFormat final : ScanFormat {
  struct Params : ParamSetOf<Params> {
    void describe(ParamVisitor&) override {}
  };
  RadiateFormat(const Params&, const PluginContext&) {}

  Guess probe(const fs::path& uri) const override {
    return findLayout(uri) ? Guess{90, "Navtech_Polar/*.png", true} : Guess{};
  }

  std::unique_ptr<ScanSource> open(const fs::path& uri, const OpenOptions& options) const override {
    const auto layout = findLayout(uri);
    if (!layout) throw inputError("{} holds no Navtech_Polar/*.png", uri.string());
    const SensorModel table = options.sensor ? *options.sensor : loadSensorModel("navtech_radiate");
    RadarFolder folder;
    const auto files = listFiles(layout->images, {".png"});
    std::map<fs::path, Stamp> stamps;
    std::map<std::uint64_t, Stamp> times;
    if (!layout->times.empty()) times = readFrameTimes(layout->times);
    for (std::size_t i = 0; i < files.size(); ++i) {
      if (layout->times.empty()) {
        stamps[files[i]] = stampFromSeconds(table.sweep_s * static_cast<double>(i + 1));
      } else {
        const auto number = numberOf(files[i]);
        const auto found = number ? times.find(*number) : times.end();
        if (found == times.end()) continue;
        stamps[files[i]] = found->second;
      }
      folder.files.push_back(files[i]);
    }
    if (folder.files.empty())
      throw inputError("{} names none of the images in {}", layout->times.string(), layout->images.string());
    folder.description =
        fmt::format("RADIATE, {} sweeps, bins of {} m and offset {} m assumed ({}), {}", folder.files.size(),
                    table.radar.range_resolution_m, table.radar.range_offset_m, table.name,
                    layout->times.empty() ? fmt::format("times made up, {} s each", table.sweep_s)
                                          : "times from Navtech_Polar.txt");
    if (folder.files.size() != files.size())
      folder.description += fmt::format(" ({} images without a time left out)", files.size() - folder.files.size());
    folder.load = [table, stamps](const fs::path& file) { return readRadarPicture(file, stamps.at(file), table); };
    return makeRadarSource(std::move(folder));
  }
};

}  // namespace

SCSLAM_REGISTER(ScanFormat, RadiateFormat, "radiate", "folder with Navtech_Polar/*.png [Navtech_Polar.txt]")

}  // namespace scslam
