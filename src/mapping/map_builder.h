// A map from a session: keyframes streamed from disk, moved into the map frame, thinned, handed to the exporters.
#pragma once
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scslam/core/registry.h"
#include "scslam/mapping/map_frame.h"
#include "scslam/session/session.h"

namespace scslam {

struct MapOptions {
  /// Edge of the voxels that keep one point each: the first measured one, unmoved [m]. 0 keeps every point. When not
  /// given, point clouds take 0.1 and octomap 0.2.
  std::optional<double> voxel_m;
  MapFrameKind frame = MapFrameKind::kMap;
  double min_range_m = 0;                       ///< nearer points of a scan are left out, and counted
  double max_range_m = 1e9;                     ///< further ones too
  std::size_t voxel_budget_bytes = 256u << 20;  ///< of the voxel set; beyond it tiles wait on disk (voxel_set.h)
};

/// What became of every point.
struct MapSummary {
  std::size_t keyframes = 0, missing_scans = 0;  ///< missing: classic folders may have lost scans
  std::uint64_t points_read = 0, out_of_range = 0, not_finite = 0, thinned = 0, points_written = 0;
  std::vector<std::filesystem::path> files;  ///< main file of the first format first
};

/// @param formats registered exporters ("ply", "octomap", …). @param progress called with the keyframes done.
/// Memory: one cloud per thread, the voxel budget, and what an exporter keeps (octomap: its tree).
/// The result does not depend on the number of threads.
/// @throw usageError for an unknown format; inputError for a missing or damaged scan (classic folders: missing ones are
/// counted instead), for a frame on Earth without satellite fixes, and when a file cannot be written.
MapSummary exportMap(const Session& session, const std::vector<std::string>& formats, const MapOptions& options,
                     const std::filesystem::path& out_folder, const PluginContext& context,
                     const std::function<void(std::size_t)>& progress = {});

}  // namespace scslam
