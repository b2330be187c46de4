#include <nlohmann/json.hpp>

#include "scslam/apps/merge/merge.h"

namespace scslam {
namespace {

nlohmann::ordered_json orNull(const std::optional<double>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json numbers(const Pose& T) {
  auto list = nlohmann::ordered_json::array();
  for (int i = 0; i < 12; ++i) list.push_back(T.matrix()(i / 4, i % 4));
  return list;
}

}  // namespace

std::string mergeJson(const MergeSummary& summary) {
  nlohmann::ordered_json json;
  json["keyframes"] = summary.keyframes, json["scans"] = summary.scans, json["loops_accepted"] = summary.loops;
  json["sessions"] = nlohmann::ordered_json::array();
  for (std::size_t s = 0; s < summary.parents.size(); ++s) {
    const MergedParent& parent = summary.parents[s];
    nlohmann::ordered_json entry = {{"name", parent.name},
                                    {"folder", parent.folder.string()},
                                    {"merged", parent.joined},
                                    {"keyframes", parent.keyframes},
                                    {"keyframes_without_scan", parent.keyframes_without_scan}};
    if (parent.joined) {
      entry["first_keyframe"] = parent.first_keyframe;
      entry["time_offset_s"] = parent.time_offset_s;
      entry["T_map_session"] = numbers(parent.T_map_parent);
    }
    if (s < summary.single_ate_rmse_m.size()) entry["ate_rmse_m"] = orNull(summary.single_ate_rmse_m[s]);
    json["sessions"].push_back(entry);
  }
  json["pairs"] = nlohmann::ordered_json::array();
  for (const MergedPair& pair : summary.pairs) {
    nlohmann::ordered_json entry = {{"sessions", {summary.parents[pair.a].name, summary.parents[pair.b].name}},
                                    {"joined", pair.joined},
                                    {"candidates", pair.trials},
                                    {"loops_accepted", pair.loops}};
    if (!pair.reason.empty()) entry["reason"] = pair.reason;
    if (pair.false_loops) entry["false_loops"] = *pair.false_loops;
    if (pair.relative_error_m) entry["relative_error_m"] = *pair.relative_error_m;
    if (pair.relative_error_deg) entry["relative_error_deg"] = *pair.relative_error_deg;
    json["pairs"].push_back(entry);
  }
  if (summary.ate_rmse_m) json["ate_rmse_m"] = *summary.ate_rmse_m;
  json["wall_s"] = summary.wall_s, json["peak_rss_mb"] = summary.peak_rss_mb;
  return json.dump(2) + "\n";
}

std::string mergeTable(const MergeSummary& summary) {
  std::string text = "\n";
  const auto row = [&text](const std::string& name, const std::string& value) {
    text += fmt::format("  {:<22} {}\n", name, value);
  };
  for (std::size_t s = 0; s < summary.parents.size(); ++s) {
    const MergedParent& parent = summary.parents[s];
    std::string value = fmt::format("{} keyframes, {}", parent.keyframes,
                                    parent.joined ? fmt::format("from {} on", parent.first_keyframe)
                                                  : "SEPARATE: not joined to the sessions of the result, left out");
    if (parent.time_offset_s > 0) value += fmt::format(", times moved by {:.0f} s", parent.time_offset_s);
    if (s < summary.single_ate_rmse_m.size() && summary.single_ate_rmse_m[s])
      value += fmt::format(", ATE {:.3f} m by itself", *summary.single_ate_rmse_m[s]);
    row(parent.name, value);
  }
  for (const MergedPair& pair : summary.pairs) {
    std::string value =
        pair.joined ? fmt::format("{} loops of {} candidates", pair.loops, pair.trials) : "not joined: " + pair.reason;
    if (pair.false_loops) value += fmt::format(", {} false", *pair.false_loops);
    if (pair.relative_error_m)
      value += fmt::format(", off by {:.3f} m, {:.3f} deg", *pair.relative_error_m, *pair.relative_error_deg);
    row(fmt::format("{} - {}", summary.parents[pair.a].name, summary.parents[pair.b].name), value);
  }
  row("together", fmt::format("{} keyframes, {} scans, {} loops", summary.keyframes, summary.scans, summary.loops));
  if (summary.ate_rmse_m) row("ATE", fmt::format("{:.3f} m", *summary.ate_rmse_m));
  row("time", fmt::format("{:.1f} s, {:.0f} MB at most", summary.wall_s, summary.peak_rss_mb));
  return text;
}

}  // namespace scslam
