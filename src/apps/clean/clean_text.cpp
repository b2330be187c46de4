#include <nlohmann/json.hpp>

#include "scslam/apps/clean/clean.h"

namespace scslam {

std::string cleanJson(const CleanSummary& summary) {
  nlohmann::ordered_json json = {{"keyframes", summary.keyframes},
                                 {"keyframes_without_scan", summary.keyframes_without_scan},
                                 {"keyframes_without_views", summary.keyframes_without_views},
                                 {"points", summary.points},
                                 {"points_removed", summary.removed},
                                 {"points_completed", summary.completed},
                                 {"points_reverted", summary.reverted},
                                 {"moving_objects_seen", summary.objects},
                                 {"static_map_points", summary.static_map_points},
                                 {"dynamic_map_points", summary.dynamic_map_points}};
  if (summary.score) {
    const CleanScore& score = *summary.score;
    json["score"] = {{"sa", score.sa()},
                     {"da", score.da()},
                     {"aa", score.aa()},
                     {"pr", score.pr()},
                     {"rr", score.rr()},
                     {"static_points", score.static_points},
                     {"dynamic_points", score.dynamic_points},
                     {"static_voxels", score.static_voxels},
                     {"dynamic_voxels", score.dynamic_voxels}};
  }
  json["wall_s"] = summary.wall_s, json["peak_rss_mb"] = summary.peak_rss_mb;
  return json.dump(2) + "\n";
}

std::string cleanTable(const CleanSummary& summary) {
  std::string text = "\n";
  const auto row = [&text](const char* name, const std::string& value) {
    text += fmt::format("  {:<16} {}\n", name, value);
  };
  const double share =
      summary.points > 0 ? 100.0 * static_cast<double>(summary.removed) / static_cast<double>(summary.points) : 0;
  row("keyframes", fmt::format("{}", summary.keyframes));
  row("points", fmt::format("{}", summary.points));
  row("removed",
      fmt::format("{} ({:.2f} %), {} of them as parts of what moved", summary.removed, share, summary.completed));
  row("reverted", fmt::format("{}: refused by views, saved by what is around them", summary.reverted));
  row("moving things", fmt::format("{} sightings", summary.objects));
  row("maps", fmt::format("{} points static, {} dynamic", summary.static_map_points, summary.dynamic_map_points));
  if (summary.score) {
    const CleanScore& score = *summary.score;
    row("points right", fmt::format("SA {:.4f}  DA {:.4f}  AA {:.4f}", score.sa(), score.da(), score.aa()));
    row("map voxels right", fmt::format("PR {:.4f}  RR {:.4f}", score.pr(), score.rr()));
  }
  row("time", fmt::format("{:.1f} s, {:.0f} MB at most", summary.wall_s, summary.peak_rss_mb));
  return text;
}

}  // namespace scslam
