#include "scslam/sensor/mulran_poses.h"

#include "scslam/core/error.h"
#include "scslam/sensor/scan_files.h"

namespace scslam {

std::filesystem::path findMulranPoses(const std::filesystem::path& folder) {
  for (const auto& place : {folder, folder / "..", folder / "sensor_data"})
    if (std::filesystem::is_regular_file(place / "global_pose.csv")) return place / "global_pose.csv";
  return {};
}

Trajectory readMulranPoses(const std::filesystem::path& file, std::string& description) {
  const TextTable table = readTextTable(file);
  if (table.rows.empty()) throw inputError("{} holds no poses", file.string());
  Trajectory trajectory;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  std::size_t repeated = 0;
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
  description = fmt::format("truth of the car body from global_pose.csv less its first position {:.3f} {:.3f} {:.3f} m",
                            origin.x(), origin.y(), origin.z());
  if (repeated != 0) description += fmt::format(" ({} rows whose time does not increase left out)", repeated);
  return trajectory;
}

}  // namespace scslam
