// A recording localised in a saved session: `scslam localize`.
#pragma once
#include <atomic>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scslam/apps/localize/localiser.h"
#include "scslam/apps/point_map/point_map.h"
#include "scslam/core/trajectory.h"

namespace scslam {

/// The configuration of the verb: a run's, and its own section.
struct LocalizeConfig : ParamSetOf<LocalizeConfig> {
  SlamParams slam;
  LocalizeParams localize;
  PointMapParams point_map;
  void describe(ParamVisitor& v) override {
    slam.describe(v);
    v.group("localize", localize, "when a place is believed, when the robot is lost");
    v.group("point_map", point_map, "how a point map (.ply, .pcd) is looked at");
  }
};

struct LocalizeOptions {
  std::filesystem::path session;  ///< or a point map (.ply, .pcd) that somebody else made
  std::string input;
  std::vector<std::string> configs, sets;  ///< over the session's own configuration
  std::string label, sensor;
  std::size_t skip = 0;
  std::optional<std::size_t> max;
  std::filesystem::path output;         ///< OUT of OUT.tum and OUT.csv
  std::filesystem::path truth;          ///< of the input, T_world_base; empty: none
  std::filesystem::path session_truth;  ///< of the session in the same world; empty: none
  bool quiet = false;
  const std::atomic<bool>* stop = nullptr;
};

/// Distance of tracked poses from the truth. With the truth of the session, it is that of the robot as seen from the
/// map's keyframe nearby: how well it is localised, whatever the map itself is off by. Without, the truth is laid on
/// the result, which hides what all poses have in common.
struct LocalizeError {
  std::string against;  ///< which of both, for people
  double rmse_m = 0, max_m = 0, median_m = 0, rmse_deg = 0;
  std::size_t poses = 0, wrong = 0;  ///< compared; more than 1 m or 5 deg away
};

struct LocalizeSummary {
  std::size_t scans = 0, tracked = 0, coasted = 0, fixes = 0, losses = 0, restarts = 0;
  std::optional<std::size_t> first_fix_scan;  ///< scans taken before it, 0-based
  std::optional<double> first_fix_s;          ///< after the first scan
  std::optional<LocalizeError> error;
  bool stopped = false;
  std::string ended_early;  ///< the input's complaint
  double search_ms_median = 0, track_ms_median = 0, wall_s = 0;
};

/// Writes OUT.tum (tracked scans, T_map_base in the session's map frame) and OUT.csv (every scan: state, pose, the 21
/// numbers of the covariance's upper triangle, the map's keyframe, why not).
/// @throw inputError for a session or an input that cannot be used; nothing is then written.
LocalizeSummary localize(const LocalizeOptions& options, const PluginContext& context);

std::string localizeJson(const LocalizeSummary& summary);
std::string localizeTable(const LocalizeSummary& summary);

}  // namespace scslam
