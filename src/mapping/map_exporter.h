// From a session to a map file: streaming, memory bounded by one tile.
#pragma once
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "scslam/core/cloud.h"
#include "scslam/core/registry.h"
#include "scslam/core/trajectory.h"
#include "scslam/graph/g2o.h"

namespace scslam {

/// What is true of the whole map; known before the first tile.
struct MapInfo {
  std::filesystem::path folder;               ///< where the exporter writes, exists
  double voxel_m = 0;                         ///< resolution asked for; 0 = the format's own default
  double min_range_m = 0, max_range_m = 1e9;  ///< of a scan; tiles hold no others
  bool planar = false;
  std::string frame = "map";                           ///< of all poses and points (map_frame.h)
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();  ///< to be added to coordinates where that frame is UTM
  std::vector<StampedPose> trajectory;                 ///< T_map_base of every scan
  PoseGraph graph;                                     ///< over T_map_base of the keyframes
  std::string input, sensor_label, sensor_table;       ///< of the session (session_writer.h)
};

/// One keyframe's share of the map.
struct MapTile {
  Cloud cloud_map;                ///< frame MapInfo::frame
  Eigen::Vector3d sensor_origin;  ///< the same, for ray casting
};

/// Plug-in interface of mapping/exporters.
class MapExporter {
 public:
  static constexpr const char* kKind = "map exporter";
  enum class Tiles {
    kNone,        ///< trajectories only; the map builder then reads no scans
    kThinned,     ///< at most one point per voxel in the whole map
    kEveryPoint,  ///< all points of each scan (occupancy counts every ray)
  };
  virtual ~MapExporter() = default;
  virtual void begin(const MapInfo& info) = 0;
  virtual void add(const MapTile& tile) = 0;
  /// @return the files written, main one first. They appear here, whole; an exporter destroyed before leaves none.
  virtual std::vector<std::filesystem::path> end() = 0;
  virtual Tiles tiles() const { return Tiles::kThinned; }
};
SCSLAM_DECLARE_REGISTRY(MapExporter);

/// A file whose header is known only at the end (counts). Written beside its final name; close() makes it appear.
class PointFile {
 public:
  /// @param header_bytes room kept for the header.
  PointFile(std::filesystem::path file, std::size_t header_bytes);
  PointFile(const PointFile&) = delete;
  PointFile& operator=(const PointFile&) = delete;
  ~PointFile();
  /// Appends each point as four little-endian float32: x y z intensity (0 where the cloud has none).
  void append(const Cloud& cloud);
  std::uint64_t points() const { return points_; }
  /// @param header exactly header_bytes long.
  std::filesystem::path close(const std::string& header);

 private:
  void check(bool ok) const;
  std::filesystem::path file_, temporary_;
  std::FILE* stream_ = nullptr;
  std::size_t header_bytes_;
  std::uint64_t points_ = 0;
};

}  // namespace scslam
