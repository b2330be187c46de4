// Input to session: everything `scslam run` does but the flags and the pictures.
#pragma once
#include <atomic>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scslam/pipeline/slam.h"
#include "scslam/sensor/scan_source.h"

namespace scslam {

struct RunOptions {
  std::string input;
  std::vector<std::string> configs;  ///< shipped names or files, later ones win
  std::vector<std::string> sets;     ///< "registration.voxel_m=0.5", after the files
  std::filesystem::path output;
  std::string label;               ///< sensor label to take; empty: the first with scans
  std::string sensor;              ///< sensor table, shipped name or file; empty: the reader's
  std::size_t skip = 0;            ///< leave out the first scans
  std::optional<std::size_t> max;  ///< take at most so many
  bool resume = false, overwrite = false, quiet = false;
  const std::atomic<bool>* stop = nullptr;  ///< set by a signal handler: finish the present scan, flush, return
  /// What is to be added to the finished session (pictures). A run killed before that is done makes it up when resumed.
  std::function<void(const struct RunSummary&)> add;
};

struct RunSummary {
  SessionEnd end = SessionEnd::kDone;
  std::string warning;     ///< what is probably wrong with the input's calibration; was logged
  std::string end_reason;  ///< the input's complaint for kEndedEarly
  SlamCounts counts;
  double input_duration_s = 0;  ///< last stamp - first stamp
  double wall_s = 0, peak_rss_mb = 0, ms_per_scan_median = 0, ms_per_scan_p95 = 0;
  StageTimes times;
  std::filesystem::path session;
  std::optional<Trajectory> ground_truth;  ///< the input's own, T_map_base
  Pose T_base_reference = Pose::Identity();
  std::string metrics_json;
};

/// @throw Error before anything was made (usage, unreadable input); once scans were taken, damage of the input ends the
/// run as kEndedEarly with the session complete up to there.
RunSummary runJob(const RunOptions& options, const PluginContext& context);

/// The same on a source that is already open (tests; embedding).
RunSummary runJob(const RunOptions& options, const PluginContext& context, ScanSource& source,
                  const std::string& format);

/// Loads a plug-in library; its SCSLAM_REGISTERs do the rest. @throw usageError with the loader's reason.
void loadPlugin(const std::string& library);

}  // namespace scslam
