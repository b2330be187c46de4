#include <algorithm>
#include <nlohmann/json.hpp>

#include "scslam/apps/evaluate.h"

namespace scslam {
namespace {

std::string lengths(const RelativeError& rpe) {
  if (rpe.lengths_m.empty()) return "none is long enough";
  if (rpe.lengths_m.size() == 1) return fmt::format("{:g} m", rpe.lengths_m.front());
  return fmt::format("{:g} … {:g} m", rpe.lengths_m.front(), rpe.lengths_m.back());
}

std::string share(const std::optional<double>& value, std::size_t part, std::size_t whole) {
  return value ? fmt::format("{:.3f} ({} of {})", *value, part, whole) : "- (nothing to count)";
}

}  // namespace

std::string evaluationJson(const Evaluation& e) {
  using Json = nlohmann::ordered_json;
  const auto orNull = [](const std::optional<double>& v) { return v ? Json(*v) : Json(nullptr); };
  Json json;
  json["trajectory"] = {{"ate_rmse_m", e.ate.rmse_m},
                        {"ate_max_m", e.ate.max_m},
                        {"odometry_ate_rmse_m", e.odometry_ate.rmse_m},
                        {"keyframe_ate_rmse_m", e.keyframe_ate.rmse_m},
                        {"rpe_trans_percent", e.rpe.trans_percent},
                        {"odometry_rpe_trans_percent", e.odometry_rpe.trans_percent},
                        {"rpe_rot_deg_per_m", e.rpe.rot_deg_per_m},
                        {"rpe_segments", e.rpe.segments},
                        {"rpe_lengths_m", e.rpe.lengths_m},
                        {"poses", e.poses},
                        {"scans", e.scans},
                        {"alignment", e.alignment}};
  if (e.planar)
    json["level"] = {{"ate_rmse_m", e.ate.level_rmse_m},
                     {"odometry_ate_rmse_m", e.odometry_ate.level_rmse_m},
                     {"rpe_trans_percent", e.level_rpe.trans_percent},
                     {"odometry_rpe_trans_percent", e.odometry_level_rpe.trans_percent}};
  json["loops"] = {{"candidates", e.loops.candidates},       {"accepted", e.loops.accepted},
                   {"true_accepted", e.loops.true_accepted}, {"false_accepted", e.loops.false_accepted},
                   {"precision", orNull(e.loops.precision)}, {"recall", orNull(e.loops.recall)},
                   {"revisits", e.loops.revisits},           {"revisit_radius_m", e.loops.revisit_radius_m}};
  auto& false_loops = json["loops"]["false"] = Json::array();
  for (const FalseLoop& loop : e.loops.false_loops)
    false_loops.push_back(
        {{"query", loop.query}, {"match", loop.match}, {"trans_m", loop.trans_m}, {"rot_deg", loop.rot_deg}});
  return json.dump(2) + "\n";
}

std::string evaluationTable(const Evaluation& e) {
  std::string text;
  const auto row = [&text](const char* what, double before, double after, const char* unit) {
    text += fmt::format("{:<26}{:>12.4f}{:>12.4f}  {}\n", what, before, after, unit);
  };
  text += fmt::format("{:<26}{:>12}{:>12}\n", "trajectory", "odometry", "optimised");
  row("  ATE, rmse", e.odometry_ate.rmse_m, e.ate.rmse_m, "m");
  if (e.planar) row("  ATE, rmse in x and y", e.odometry_ate.level_rmse_m, e.ate.level_rmse_m, "m");
  row("  ATE, largest", e.odometry_ate.max_m, e.ate.max_m, "m");
  row("  RPE, translation", e.odometry_rpe.trans_percent, e.rpe.trans_percent, "%");
  if (e.planar) row("  RPE, in x and y", e.odometry_level_rpe.trans_percent, e.level_rpe.trans_percent, "%");
  row("  RPE, rotation", e.odometry_rpe.rot_deg_per_m, e.rpe.rot_deg_per_m, "deg/m");
  text += fmt::format("{:<26}{:>24.4f}  m\n", "  ATE of the keyframes", e.keyframe_ate.rmse_m);
  text += fmt::format("  {} of {} scans have truth; {}\n", e.poses, e.scans, e.alignment);
  if (e.planar) text += "  2-D data: heights and tilts are not measured\n";
  text += fmt::format("  RPE over {} segments: {}\n", e.rpe.segments, lengths(e.rpe));
  text += fmt::format("loops\n  candidates {}, accepted {}: {} true, {} false\n", e.loops.candidates, e.loops.accepted,
                      e.loops.true_accepted, e.loops.false_accepted);
  constexpr std::size_t kShown = 10;
  const std::vector<FalseLoop>& wrong = e.loops.false_loops;
  for (std::size_t i = 0; i < std::min(wrong.size(), kShown); ++i)
    text += fmt::format("    {} -> {} is wrong by {:.2f} m, {:.1f} deg\n", wrong[i].query, wrong[i].match,
                        wrong[i].trans_m, wrong[i].rot_deg);
  if (wrong.size() > kShown) text += fmt::format("    and {} more (--json lists all)\n", wrong.size() - kShown);
  text += fmt::format("  precision {}\n",
                      share(e.loops.precision, e.loops.true_accepted, e.loops.true_accepted + e.loops.false_accepted));
  text += fmt::format("  recall    {} of the keyframes within {:g} m of an earlier place\n",
                      share(e.loops.recall, e.loops.revisits_closed, e.loops.revisits), e.loops.revisit_radius_m);
  return text;
}

}  // namespace scslam
