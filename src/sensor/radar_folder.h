// A source whose scans are radar images of one folder: what the radar layouts have in common.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "scslam/sensor/scan_source.h"

namespace scslam {

struct RadarFolder {
  std::vector<std::filesystem::path> files;  ///< in order
  std::optional<Trajectory> truth;           ///< T_map_base
  std::string description;
  std::function<RadarScan(const std::filesystem::path&)> load;  ///< @throw inputError
};

/// Sweeps file by file, mended (radar_sweep.h); a scan's stamp is its first azimuth's.
std::unique_ptr<ScanSource> makeRadarSource(RadarFolder folder);

}  // namespace scslam
