#include "scslam/apps/loop_figures.h"

#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace scslam {
namespace {

/// The loop's measured pose against the true one.
FalseLoop errorOf(const LoopRecord& loop, const Pose& T_truth_match, const Pose& T_truth_query) {
  const Pose difference = (T_truth_match.inverse() * T_truth_query).inverse() * loop.T_match_query;
  return {loop.query, loop.match, difference.translation().norm(), rotationAngle(difference) * 180 / M_PI};
}

/// Keyframes whose true position comes within the radius of an earlier one, enough way before.
std::set<std::size_t> revisits(const std::vector<std::optional<Pose>>& truth, const EvaluationOptions& options) {
  using Cell = std::pair<std::int64_t, std::int64_t>;
  std::map<Cell, std::vector<std::pair<std::size_t, double>>> cells;  // keyframe and way driven, per square
  const double side = std::max(options.revisit_radius_m, 1e-3);
  const auto cellOf = [&](const Eigen::Vector3d& p) {
    return Cell(std::llround(std::floor(p.x() / side)), std::llround(std::floor(p.y() / side)));
  };
  std::set<std::size_t> result;
  double way = 0;
  const Pose* last = nullptr;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    if (!truth[k]) continue;
    const Eigen::Vector3d p = truth[k]->translation();
    if (last != nullptr) way += (p - last->translation()).norm();
    last = &*truth[k];
    const Cell home = cellOf(p);
    for (std::int64_t dx = -1; dx <= 1; ++dx)
      for (std::int64_t dy = -1; dy <= 1; ++dy)
        if (const auto found = cells.find({home.first + dx, home.second + dy}); found != cells.end())
          for (const auto& [earlier, way_then] : found->second)
            if (way - way_then >= options.revisit_min_travel_m &&
                (truth[earlier]->translation() - p).norm() <= options.revisit_radius_m)
              result.insert(k);
    cells[home].push_back({k, way});
  }
  return result;
}

}  // namespace

LoopFigures loopFigures(const std::vector<LoopRecord>& loops, const std::vector<std::optional<Pose>>& T_truth_keyframe,
                        const EvaluationOptions& options) {
  LoopFigures figures;
  figures.candidates = loops.size();
  figures.revisit_radius_m = options.revisit_radius_m;
  std::set<std::size_t> closed;
  for (const LoopRecord& loop : loops) {
    if (!loop.accepted) continue;
    ++figures.accepted;
    const auto &match = T_truth_keyframe[loop.match], &query = T_truth_keyframe[loop.query];
    if (!match || !query) continue;
    const FalseLoop error = errorOf(loop, *match, *query);
    if (error.trans_m <= options.loop_trans_m && error.rot_deg <= options.loop_rot_deg) {
      ++figures.true_accepted;
      closed.insert(loop.query);
    } else {
      ++figures.false_accepted;
      figures.false_loops.push_back(error);
    }
  }
  for (const std::size_t k : revisits(T_truth_keyframe, options)) {
    ++figures.revisits;
    figures.revisits_closed += closed.count(k);
  }
  if (const std::size_t judged = figures.true_accepted + figures.false_accepted; judged > 0)
    figures.precision = static_cast<double>(figures.true_accepted) / static_cast<double>(judged);
  if (figures.revisits > 0)
    figures.recall = static_cast<double>(figures.revisits_closed) / static_cast<double>(figures.revisits);
  return figures;
}

}  // namespace scslam
