#include "scslam/apps/compare.h"

#include <nlohmann/json.hpp>

#include "scslam/core/file.h"
#include "scslam/session/layout.h"

namespace scslam {
namespace {

void readMetrics(ComparedRun& run, const std::filesystem::path& file) {
  if (!std::filesystem::is_regular_file(file)) return;
  const auto json = nlohmann::json::parse(readFile(file, 1 << 24), nullptr, false);
  if (!json.is_object()) throw inputError("{} is no JSON object", file.string());
  const auto number = [&](const nlohmann::json& object, const char* key) {
    return object.contains(key) && object[key].is_number() ? object[key].get<double>() : 0.0;
  };
  run.lost_scans = static_cast<std::size_t>(number(json, "lost_scans"));
  run.realtime_factor = number(json, "realtime_factor");
  run.peak_rss_mb = number(json, "peak_rss_mb");
  if (json.contains("ms_per_scan")) run.ms_per_scan = number(json["ms_per_scan"], "median");
  if (json.contains("stages_ms") && run.scans > 0)
    run.odometry_ms_per_scan = number(json["stages_ms"], "odometry") / static_cast<double>(run.scans);
}

}  // namespace

void readRun(ComparedRun& run, const std::filesystem::path& folder, const std::optional<Trajectory>& truth) {
  if (!std::filesystem::exists(folder / layout::kManifest)) return;
  Session session = Session::open(folder);
  if (session.scans().empty()) {
    if (run.failure.empty()) run.failure = "no scan was taken";
    return;
  }
  run.scans = session.scans().size();
  run.keyframes = session.keyframes().size();
  for (const LoopRecord& loop : session.loops()) run.loops += loop.accepted;
  readMetrics(run, folder / layout::kMetrics);
  if (truth) {
    run.evaluation = evaluate(session, *truth);
    run.steps = stepConsistency(session, *run.evaluation);
  }
  run.session = std::move(session);
}

}  // namespace scslam
