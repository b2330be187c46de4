// A source whose scans are files of one folder: what all folder formats have in common.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "scslam/sensor/scan_source.h"

namespace scslam {

struct FolderScans {
  std::vector<std::filesystem::path> files;      ///< in order
  std::vector<Stamp> stamps;                     ///< per file
  std::vector<std::optional<Pose>> T_odom_base;  ///< per file, or empty
  std::optional<Trajectory> truth;               ///< T_map_base
  Pose T_base_sensor = Pose::Identity();
  Pose T_base_reference = Pose::Identity();
  std::optional<SensorModel> table;  ///< completes rings and times
  bool deskewed = false, planar = false;
  std::string label;
  std::string description;
  std::function<Cloud(const std::filesystem::path&)> load;  ///< @throw inputError
};

std::unique_ptr<ScanSource> makeFolderSource(FolderScans scans);

/// Per-file poses as a trajectory; files without a pose and stamps that do not increase are left out. nullopt when
/// nothing is left.
std::optional<Trajectory> trajectoryOf(const std::vector<Stamp>& stamps, const std::vector<std::optional<Pose>>& poses);

/// 10 Hz, counted from 0: by file number where all files are numbered within a drive's reach, otherwise by order.
std::vector<Stamp> madeUpStamps(const std::vector<std::filesystem::path>& files);

}  // namespace scslam
