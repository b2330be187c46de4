// What changed between two visits: `scslam changes`.
//
// Both lie in one frame already: a merged session. Each scan of one visit is held against the scans that the other took
// around there (sight_image.h): what they looked through was not there then. What moved while it was measured is no
// change: its own visit's scans looked through it, too. The terms are those of G. Kim and A. Kim, "LT-mapper", ICRA
// 2022: appeared (positive difference), disappeared (negative difference), stayed (coexisting).
#pragma once
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "scslam/core/cloud.h"
#include "scslam/core/params.h"
#include "scslam/core/registry.h"

namespace scslam {

struct ChangeParams : ParamSetOf<ChangeParams> {
  double reach_m = 30;
  int views = 24, own_views = 16;
  double margin_m = 0.3, margin_per_m = 0.01;
  double voxel_m = 0.2;
  int min_free = 3;
  double free_share = 0.7;
  double gap_m = 0.4;
  int min_voxels = 15;
  double cache_mb = 300;
  void describe(ParamVisitor& v) override;
};

struct ChangesOptions {
  std::filesystem::path session;  ///< a merged one
  std::string older, newer;       ///< names of two of its parents; empty: the first and the last
  std::filesystem::path output;   ///< empty: SESSION/changes
  std::vector<std::string> sets;  ///< of ChangeParams
  bool overwrite = false, quiet = false;
  const std::atomic<bool>* stop = nullptr;  ///< set by a signal handler: remove what was begun and throw kStopped
};

enum class Change : std::uint8_t { kStayed, kAppeared, kDisappeared, kUnseen };

/// Something that came or went.
struct ChangedThing {
  Change change = Change::kAppeared;
  Eigen::Vector3f low, high;  ///< frame map [m]
  std::size_t voxels = 0;
};

/// One point for each voxel that one of the visits saw.
struct ChangeMap {
  Cloud cloud_map;
  std::vector<Change> change;  ///< by point; kUnseen: the other visit's scans say nothing about it
};

struct ChangesSummary {
  std::filesystem::path folder;
  std::string older, newer;
  std::size_t older_keyframes = 0, newer_keyframes = 0;
  std::size_t stayed = 0, appeared = 0, disappeared = 0, unseen = 0;  ///< voxels
  std::uint64_t moving_points = 0;                                    ///< left out
  std::vector<ChangedThing> things;                                   ///< largest first
  ChangeMap map;
  double wall_s = 0, peak_rss_mb = 0;
};

/// Writes OUTPUT/changes.ply (x y z, colour, change), things.csv and changes.json. The session stays as it is; the
/// result does not depend on the number of threads. Memory grows with the map (40 bytes a voxel).
/// @throw usageError for an output that may not be replaced and names that the session does not have; inputError for
/// sessions that were not merged; Error(kStopped). Then nothing was written.
ChangesSummary findChanges(const ChangesOptions& options, const PluginContext& context);

std::string changesJson(const ChangesSummary& summary);
std::string changesTable(const ChangesSummary& summary);

}  // namespace scslam
