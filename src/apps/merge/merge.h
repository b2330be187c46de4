// Several saved sessions in one frame: `scslam merge`.
//
// Nothing is known of where the sessions began. Places of each are looked for in the others (Scan Context++ or what the
// configuration names), every candidate is registered and judged like a loop of a run, and since no odometry links two
// sessions, a pair is joined only by several loops that agree with each other, spread over some way. The sessions that
// hang together then become one pose graph; where its poses say that two sessions pass each other, more loops are
// tried, those first that tell most, and what they say must not contradict the first ones.
#pragma once
#include <atomic>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scslam/apps/point_map/point_map.h"
#include "scslam/core/trajectory.h"
#include "scslam/pipeline/slam_params.h"

namespace scslam {

struct MergeParams : ParamSetOf<MergeParams> {
  int min_loops = 3;
  double min_spread_m = 10;
  int enough_loops = 12, max_trials = 600, rounds_in_vain = 2;
  double trial_spacing_m = 5;
  double radius_m = 5, loop_distance_m = 3;
  int max_loops = 200;
  double max_contradictions = 0.5;
  PointMapParams point_map;
  void describe(ParamVisitor& v) override;
};

/// The configuration of the verb: a run's, whose place, registration and graph sections count, and the merge's own.
struct MergeConfig : ParamSetOf<MergeConfig> {
  SlamParams slam;
  MergeParams merge;
  void describe(ParamVisitor& v) override {
    slam.describe(v);
    v.group("merge", merge, "what joins two sessions");
  }
};

struct MergeOptions {
  /// Two or more, in any order: sessions, and point maps (.ply, .pcd) that somebody else made. A point map does not
  /// bend (of several, the first) and its frame is the result's.
  std::vector<std::filesystem::path> sessions;
  std::vector<std::string> configs, sets;  ///< over the configuration of the longest session
  std::filesystem::path output;
  /// True trajectories of the sessions, in their order and in one world frame, for the figures; empty: none.
  std::vector<std::filesystem::path> truths;
  bool overwrite = false, quiet = false;
  const std::atomic<bool>* stop = nullptr;  ///< set by a signal handler: remove what was begun and throw kStopped
};

/// A parent as the merge saw it.
struct MergedParent {
  std::filesystem::path folder;  ///< or point map
  std::string name;              ///< of its folder, made unique
  std::size_t keyframes = 0, keyframes_without_scan = 0;
  bool joined = false;  ///< is in the result
  KeyframeId first_keyframe = 0;
  Pose T_map_parent = Pose::Identity();  ///< its own map frame in the result's, as it moved on the whole
  double time_offset_s = 0;              ///< added to its stamps
};

/// Two sessions, by number among MergeSummary::parents.
struct MergedPair {
  std::size_t a = 0, b = 0;
  std::size_t trials = 0, loops = 0;  ///< candidates registered, loops accepted
  bool joined = false;
  std::string reason;  ///< why not
  std::optional<std::size_t> false_loops;
  /// Where b's poses lie against a's, over those within reach of each other: rms, against the truth.
  std::optional<double> relative_error_m, relative_error_deg;
};

struct MergeSummary {
  std::vector<MergedParent> parents;  ///< in the order of the result
  std::vector<MergedPair> pairs;
  std::size_t keyframes = 0, scans = 0, loops = 0;  ///< of the result
  std::optional<double> ate_rmse_m;
  std::vector<std::optional<double>> single_ate_rmse_m;  ///< by parent, of its own poses
  double wall_s = 0, peak_rss_mb = 0;
};

/// @return what was written to options.output. The order of options.sessions changes no byte of it.
/// @throw usageError for sessions given twice (copies and a parent beside its merge included) or an output that may not
/// be replaced; inputError for sessions that cannot be merged at all; Error(kQualityGate) when no two of them overlap;
/// Error(kStopped). In all these cases nothing was written.
MergeSummary mergeSessions(const MergeOptions& options, const PluginContext& context);

std::string mergeJson(const MergeSummary& summary);
std::string mergeTable(const MergeSummary& summary);

}  // namespace scslam
