#include <nlohmann/json.hpp>

#include "scslam/apps/localize/localize.h"

namespace scslam {

std::string localizeJson(const LocalizeSummary& s) {
  nlohmann::ordered_json json = {{"scans", s.scans},
                                 {"tracked", s.tracked},
                                 {"coasted", s.coasted},
                                 {"success_rate", s.scans > 0 ? static_cast<double>(s.tracked) / s.scans : 0.0},
                                 {"fixes", s.fixes},
                                 {"losses", s.losses},
                                 {"odometry_restarts", s.restarts},
                                 {"first_fix", nullptr}};
  if (s.first_fix_scan) json["first_fix"] = {{"scan", *s.first_fix_scan}, {"time_s", *s.first_fix_s}};
  if (s.error)
    json["error"] = {{"rmse_m", s.error->rmse_m},     {"median_m", s.error->median_m}, {"max_m", s.error->max_m},
                     {"rmse_deg", s.error->rmse_deg}, {"poses", s.error->poses},       {"wrong", s.error->wrong},
                     {"against", s.error->against}};
  json["ms_per_scan"] = {{"search", s.search_ms_median}, {"track", s.track_ms_median}};
  json["wall_s"] = s.wall_s;
  json["ended"] = s.stopped ? "stopped" : s.ended_early.empty() ? "done" : "input ended early";
  return json.dump(2) + "\n";
}

std::string localizeTable(const LocalizeSummary& s) {
  std::string text = "\n";
  const auto row = [&text](const char* name, const std::string& value) {
    text += fmt::format("  {:<22} {}\n", name, value);
  };
  row("scans", fmt::format("{}: {} tracked, {} by odometry alone, {} without a pose", s.scans, s.tracked, s.coasted,
                           s.scans - s.tracked - s.coasted));
  row("first fix", s.first_fix_scan
                       ? fmt::format("at scan {} of the input, after {:.2f} s", *s.first_fix_scan + 1, *s.first_fix_s)
                       : "none: no place was recognised");
  if (s.losses + s.restarts > 0)
    row("lost", fmt::format("{} times, odometry begun anew {} times, {} fixes in all", s.losses, s.restarts, s.fixes));
  if (s.error)
    row("error", fmt::format("{:.3f} m rms, {:.3f} m median, {:.3f} m at most, {:.3f} deg rms; {} of {} wrong ({})",
                             s.error->rmse_m, s.error->median_m, s.error->max_m, s.error->rmse_deg, s.error->wrong,
                             s.error->poses, s.error->against));
  row("time", fmt::format("{:.1f} s; a scan {:.0f} ms searching, {:.0f} ms tracking (median, odometry apart)", s.wall_s,
                          s.search_ms_median, s.track_ms_median));
  return text;
}

}  // namespace scslam
