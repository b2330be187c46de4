// MulRan: [sensor_data/]Ouster/<ns>.bin (float32 x y z intensity, firing by firing, zeros where nothing came back) and
// global_pose.csv (ns, 3x4 of the car body in UTM). Base is the car body; the LiDAR looks backwards (sensor table).
#include "scslam/core/error.h"
#include "scslam/sensor/cloud_files.h"
#include "scslam/sensor/folder_source.h"
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
    for (const fs::path& folder : {uri, uri / "..", uri / "sensor_data"})
      if (layout.poses.empty() && fs::is_regular_file(folder / "global_pose.csv"))
        layout.poses = folder / "global_pose.csv";
    if (!layout.poses.empty()) layout.found += " and global_pose.csv";
    return layout;
  }
  return std::nullopt;
}

/// Poses relative to the first position: UTM coordinates of 10^6 m leave no digits for a float.
Trajectory readGlobalPoses(const fs::path& file, Eigen::Vector3d& origin, std::size_t& repeated) {
  const TextTable table = readTextTable(file);
  if (table.rows.empty()) throw inputError("{} holds no poses", file.string());
  Trajectory trajectory;
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const Stamp stamp = stampFromNanoseconds(table.integer(row, 0));
    Pose T = Pose::Identity();
    for (int i = 0; i < 12; ++i) T.matrix()(i / 4, i % 4) = table.number(row, static_cast<std::size_t>(i) + 1);
    if (!isRigid(T)) throw inputError("{}:{}: no rigid motion", file.string(), table.rows[row].line);
    if (row == 0) origin = T.translation();
    if (!trajectory.poses.empty() && stamp <= trajectory.poses.back().stamp) {
      ++repeated;
      continue;
    }
    T.translation() -= origin;
    trajectory.poses.push_back({stamp, orthonormalised(T)});
  }
  return trajectory;
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
      Eigen::Vector3d origin = Eigen::Vector3d::Zero();
      std::size_t repeated = 0;
      scans.truth = readGlobalPoses(layout->poses, origin, repeated);
      scans.description +=
          fmt::format(", truth of the car body from global_pose.csv less its first position {:.3f} {:.3f} {:.3f} m",
                      origin.x(), origin.y(), origin.z());
      if (repeated != 0) scans.description += fmt::format(" ({} rows whose time does not increase left out)", repeated);
    }
    scans.label = "Ouster";
    scans.load = readXyziBin;
    return makeFolderSource(std::move(scans));
  }
};

}  // namespace

SCSLAM_REGISTER(ScanFormat, MulranFormat, "mulran", "folder with [sensor_data/]Ouster/*.bin [global_pose.csv]")

}  // namespace scslam
