// From a session to a map file: streaming, memory bounded by one tile.
#pragma once
#include <filesystem>
#include <vector>

#include "scslam/core/cloud.h"
#include "scslam/core/registry.h"
#include "scslam/core/trajectory.h"

namespace scslam {

/// What is true of the whole map; known before the first tile.
struct MapInfo {
  std::filesystem::path folder;  ///< where the exporter writes, exists
  double voxel_m = 0.1;          ///< resolution asked for
  bool planar = false;
  std::vector<StampedPose> trajectory;  ///< T_map_base of every scan
};

/// One keyframe's share of the map.
struct MapTile {
  Cloud cloud_map;                ///< frame map
  Eigen::Vector3d sensor_origin;  ///< frame map, for ray casting
};

/// Plug-in interface of mapping/exporters.
class MapExporter {
 public:
  static constexpr const char* kKind = "map exporter";
  virtual ~MapExporter() = default;
  virtual void begin(const MapInfo& info) = 0;
  virtual void add(const MapTile& tile) = 0;
  /// @return the files written, main one first.
  virtual std::vector<std::filesystem::path> end() = 0;
  /// Trajectory-only formats need no tiles; the map builder then reads no scans.
  virtual bool needsTiles() const { return true; }
};
SCSLAM_DECLARE_REGISTRY(MapExporter);

}  // namespace scslam
