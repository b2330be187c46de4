#include "scslam/sensor/radar_truth.h"

#include <cmath>
#include <cstdint>

#include "scslam/core/error.h"
#include "scslam/sensor/scan_files.h"

namespace scslam {
namespace {

/// From a frame x forward, y right, z down to x forward, y left, z up, and back.
const Eigen::Matrix3d kUpsideDown = Eigen::Vector3d(1, -1, -1).asDiagonal();

bool startsWithDigit(const std::string& cell) { return !cell.empty() && cell[0] >= '0' && cell[0] <= '9'; }

/// The table without its line of column names.
TextTable readNumbers(const std::filesystem::path& file) {
  TextTable table = readTextTable(file);
  if (!table.rows.empty() && !startsWithDigit(table.rows.front().cells.front())) table.rows.erase(table.rows.begin());
  if (table.rows.empty()) throw inputError("{} holds no poses", file.string());
  return table;
}

Stamp microseconds(const TextTable& table, std::size_t row, std::size_t column) {
  constexpr std::int64_t kMost = 9'000'000'000'000'000;
  const std::int64_t value = table.integer(row, column);
  if (value < 0 || value > kMost)
    throw inputError("{}:{}: absurd time {}", table.file.string(), table.rows[row].line, value);
  return stampFromNanoseconds(1000 * value);
}

}  // namespace

Trajectory readOxfordTruth(const std::filesystem::path& file, std::size_t& broken_at) {
  enum Column { kSource, kDestination, kX, kY, kZ, kRoll, kPitch, kYaw };
  const TextTable table = readNumbers(file);
  Trajectory trajectory;
  trajectory.poses.push_back({microseconds(table, 0, kDestination), Pose::Identity()});
  broken_at = 0;
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const Stamp source = microseconds(table, row, kSource);
    if (microseconds(table, row, kDestination) != trajectory.poses.back().stamp ||
        source <= trajectory.poses.back().stamp) {
      broken_at = table.rows[row].line;
      break;
    }
    Pose T_destination_source = Pose::Identity();
    T_destination_source.translation() << table.number(row, kX), -table.number(row, kY), -table.number(row, kZ);
    T_destination_source.linear() = (Eigen::AngleAxisd(-table.number(row, kYaw), Eigen::Vector3d::UnitZ()) *
                                     Eigen::AngleAxisd(-table.number(row, kPitch), Eigen::Vector3d::UnitY()) *
                                     Eigen::AngleAxisd(table.number(row, kRoll), Eigen::Vector3d::UnitX()))
                                        .toRotationMatrix();
    trajectory.poses.push_back({source, trajectory.poses.back().T * T_destination_source});
  }
  return trajectory;
}

Trajectory readBoreasTruth(const std::filesystem::path& file) {
  enum Column { kTime, kEast, kNorth, kUp, kRoll = 7, kPitch, kYaw };
  const TextTable table = readNumbers(file);
  Trajectory trajectory;
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const Stamp stamp = microseconds(table, row, kTime);
    if (!trajectory.poses.empty() && stamp <= trajectory.poses.back().stamp) continue;
    // The kit's rotations turn frames, not points: roll(r) pitch(p) yaw(y), each transposed.
    const Eigen::Matrix3d R_enu_radar = (Eigen::AngleAxisd(-table.number(row, kRoll), Eigen::Vector3d::UnitX()) *
                                         Eigen::AngleAxisd(-table.number(row, kPitch), Eigen::Vector3d::UnitY()) *
                                         Eigen::AngleAxisd(-table.number(row, kYaw), Eigen::Vector3d::UnitZ()))
                                            .toRotationMatrix();
    Pose T = Pose::Identity();
    T.translation() << table.number(row, kEast), table.number(row, kNorth), table.number(row, kUp);
    T.linear() = R_enu_radar * kUpsideDown;
    trajectory.poses.push_back({stamp, T});
  }
  return trajectory;
}

}  // namespace scslam
