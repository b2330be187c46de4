// KITTI odometry: velodyne/NNNNNN.bin, times.txt, calib.txt (Tr: velodyne to camera 0), poses.txt or
// ../../poses/XX.txt.
//
// Base is the LiDAR. With calib.txt the poses are those of the left camera in the first camera's frame, so
//   T_base_reference = T_velo_cam = Tr^-1   and   T_map_base = Tr^-1 T_cam0_cam Tr,
// a map whose axes are the first LiDAR's. Without calib.txt the poses are the LiDAR's own. The benchmark's scans are
// motion-compensated to the stamp in times.txt.
#include "scslam/core/error.h"
#include "scslam/sensor/cloud_files.h"
#include "scslam/sensor/folder_source.h"
#include "scslam/sensor/scan_files.h"

namespace scslam {
namespace {

namespace fs = std::filesystem;

/// T_cam_velo of calib.txt; nullopt when there is no such file.
std::optional<Pose> readCalibration(const fs::path& file) {
  if (!fs::is_regular_file(file)) return std::nullopt;
  const TextTable table = readTextTable(file);
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const std::string& key = table.rows[row].cells[0];
    if (key != "Tr:" && key != "Tr_velo_to_cam:" && key != "Tr_velo_cam:") continue;
    Pose T = Pose::Identity();
    for (int i = 0; i < 12; ++i) T.matrix()(i / 4, i % 4) = table.number(row, static_cast<std::size_t>(i) + 1);
    if (!isRigid(T)) throw inputError("{}:{}: Tr is no rigid motion", file.string(), table.rows[row].line);
    return orthonormalised(T);
  }
  throw inputError("{} has no line 'Tr:' (velodyne to camera)", file.string());
}

std::optional<fs::path> posesFile(const fs::path& folder) {
  const fs::path clean = fs::absolute(folder / "").lexically_normal().parent_path();
  for (const fs::path& file :
       {folder / "poses.txt", clean.parent_path().parent_path() / "poses" / (clean.filename().string() + ".txt")})
    if (fs::is_regular_file(file)) return file;
  return std::nullopt;
}

struct KittiFormat final : ScanFormat {
  struct Params : ParamSetOf<Params> {
    void describe(ParamVisitor&) override {}
  };
  KittiFormat(const Params&, const PluginContext&) {}

  Guess probe(const fs::path& uri) const override {
    if (listFiles(uri / "velodyne", {".bin"}).empty()) return {};
    if (fs::is_regular_file(uri / "times.txt")) return {90, "velodyne/*.bin and times.txt"};
    return {80, "velodyne/*.bin"};
  }

  std::unique_ptr<ScanSource> open(const fs::path& uri, const OpenOptions& options) const override {
    FolderScans scans;
    scans.files = listFiles(uri / "velodyne", {".bin"});
    if (scans.files.empty()) throw inputError("{} holds no velodyne/*.bin", uri.string());
    const bool timed = fs::is_regular_file(uri / "times.txt");
    scans.stamps = timed ? readTimes(uri / "times.txt", scans.files) : madeUpStamps(scans.files);
    scans.description = fmt::format("KITTI odometry, {} scans, {}", scans.files.size(),
                                    timed ? "times.txt" : "no times.txt: 10 Hz made up");
    const auto T_cam_velo = readCalibration(uri / "calib.txt");
    if (T_cam_velo) scans.T_base_reference = T_cam_velo->inverse();
    addPoses(uri, T_cam_velo.has_value(), scans);
    if (options.sensor) {
      scans.table = options.sensor;
      scans.T_base_sensor = options.sensor->T_base_sensor();
    }
    scans.deskewed = true;
    scans.label = "velodyne";
    scans.load = readXyziBin;
    return makeFolderSource(std::move(scans));
  }

 private:
  static void addPoses(const fs::path& uri, bool of_camera, FolderScans& scans) {
    const auto read = [&](const fs::path& file) {
      auto poses = readPosesOfScans(file, scans.files, scans.stamps);
      for (auto& T : poses)
        if (T) T = orthonormalised(scans.T_base_reference * *T * scans.T_base_reference.inverse());
      return poses;
    };
    if (const auto file = posesFile(uri)) {
      scans.truth = trajectoryOf(scans.stamps, read(*file));
      scans.description +=
          fmt::format(", truth from {} ({} poses)", file->filename().string(), of_camera ? "camera" : "LiDAR");
    }
    if (fs::is_regular_file(uri / "odometry.txt")) {
      scans.T_odom_base = read(uri / "odometry.txt");
      scans.description += ", odometry.txt";
    }
  }
};

}  // namespace

SCSLAM_REGISTER(ScanFormat, KittiFormat, "kitti", "folder with velodyne/*.bin [times.txt calib.txt poses.txt]")

}  // namespace scslam
