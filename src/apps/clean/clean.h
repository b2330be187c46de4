// Moving objects removed from a saved session: `scslam clean`.
//
// A point that other scans looked through was not there when they were taken. Every scan is held against others
// around it (range-image visibility, signed, with occlusion: G. Kim and A. Kim, "Remove, then Revert:
// Static Point cloud Map Construction using Multiresolution Range Images", IROS 2020), each as fine as its sensor is.
// Beams that came back from nowhere testify as well. What the views refuse point by point is then judged thing by
// thing: things that mostly moved go whole, single refused points are reverted, the ground is only taken where it
// surely is none. Scans keep their density: nothing is thinned.
#pragma once
#include <atomic>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scslam/pipeline/slam_params.h"

namespace scslam {

struct CleanParams : ParamSetOf<CleanParams> {
  int soon_views = 16, later_views = 32;
  double reach_m = 60;
  double margin_m = 0.2, margin_per_m = 0.005, sky_m = 40;
  int min_free = 2, sure_free = 5;
  double free_share = 0.5;
  double object_height_m = 0.2, ground_height_m = 0.04;
  double gap_m = 0.35, whole_share = 0.35, part_share = 0.7;
  int min_object_points = 2, min_part_points = 4;
  double cache_mb = 300;
  void describe(ParamVisitor& v) override;
};

struct CleanConfig : ParamSetOf<CleanConfig> {
  SlamParams slam;  ///< of the session; its place section makes the descriptors of the cleaned scans
  CleanParams clean;
  void describe(ParamVisitor& v) override {
    slam.describe(v);
    v.group("clean", clean, "what is taken for moving");
  }
};

enum class LabelStyle { kSemanticKitti, kPandaSet };

struct CleanOptions {
  std::filesystem::path session;
  std::filesystem::path output;  ///< empty: SESSION/clean
  std::vector<std::string> configs, sets;
  /// True labels of all scans of the input (one little-endian uint32 per point, files sorted by name); empty: no
  /// scores.
  std::filesystem::path labels;
  LabelStyle label_style = LabelStyle::kSemanticKitti;
  bool overwrite = false, quiet = false;
  const std::atomic<bool>* stop = nullptr;  ///< set by a signal handler: remove what was begun and throw kStopped
};

/// Against true labels. Points without a label do not count.
struct CleanScore {
  std::uint64_t static_points = 0, static_kept = 0, dynamic_points = 0, dynamic_removed = 0;
  /// Of the map's voxels of 0.2 m, static or dynamic by most of their points: those that keep a static point, and those
  /// that lose all of their dynamic ones.
  std::uint64_t static_voxels = 0, static_voxels_kept = 0, dynamic_voxels = 0, dynamic_voxels_removed = 0;

  double sa() const { return share(static_kept, static_points); }              ///< static accuracy
  double da() const { return share(dynamic_removed, dynamic_points); }         ///< dynamic accuracy
  double aa() const;                                                           ///< their geometric mean
  double pr() const { return share(static_voxels_kept, static_voxels); }       ///< preservation rate
  double rr() const { return share(dynamic_voxels_removed, dynamic_voxels); }  ///< rejection rate

 private:
  static double share(std::uint64_t part, std::uint64_t all) {
    return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : 1;
  }
};

struct CleanSummary {
  std::filesystem::path folder;
  std::size_t keyframes = 0, keyframes_without_scan = 0, keyframes_without_views = 0;
  std::uint64_t points = 0, removed = 0;
  std::uint64_t completed = 0, reverted = 0;  ///< scan_judge.h
  std::size_t objects = 0;                    ///< sightings of something that moves, summed over the scans
  std::size_t static_map_points = 0, dynamic_map_points = 0;
  std::optional<CleanScore> score;
  double wall_s = 0, peak_rss_mb = 0;
};

/// Writes OUTPUT/static, the session with what stands, OUTPUT/dynamic, the same with what moved, the map of each, and
/// clean.json. The session itself stays as it is. The result does not depend on the number of threads.
/// @throw usageError for an output that may not be replaced; inputError for sessions that cannot be cleaned (fewer than
/// two scans, missing or damaged ones) and labels that do not fit; Error(kStopped). Then nothing was written.
CleanSummary cleanSession(const CleanOptions& options, const PluginContext& context);

std::string cleanJson(const CleanSummary& summary);
std::string cleanTable(const CleanSummary& summary);

}  // namespace scslam
