// Several front-ends over several inputs: the figures side by side.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scslam/apps/evaluate.h"
#include "scslam/apps/nees.h"

namespace scslam {

/// One front-end over one input.
struct ComparedRun {
  std::string input, frontend;
  std::string failure;     ///< empty: it ran to the end of the input
  bool with_loops = true;  ///< were loops looked for
  /// The rest is there only when `session` is: a run that was refused or crashed at once has none.
  std::optional<Session> session;
  std::optional<Evaluation> evaluation;  ///< absent without truth
  StepConsistency steps;
  std::size_t scans = 0, keyframes = 0, lost_scans = 0, loops = 0;
  double cpu_ms_per_scan = 0;       ///< of the whole process, all threads, reading included
  double odometry_ms_per_scan = 0;  ///< wall, mean
  double ms_per_scan = 0;           ///< wall, all stages, median
  double realtime_factor = 0, peak_rss_mb = 0;
};

/// Fills in what `folder` holds: session, metrics.json, and with `truth` (T_truth_base) the figures. A folder without a
/// session leaves the run as it is; one without scans becomes a failure.
void readRun(ComparedRun& run, const std::filesystem::path& folder, const std::optional<Trajectory>& truth);

/// One row per run for a terminal; the same as a Markdown table; and as JSON with every figure `eval` has.
std::string compareTable(const std::vector<ComparedRun>& runs);
std::string compareMarkdown(const std::vector<ComparedRun>& runs);
std::string compareJson(const std::vector<ComparedRun>& runs);

}  // namespace scslam
