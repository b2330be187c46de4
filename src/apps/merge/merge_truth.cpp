#include "scslam/apps/merge/merge_truth.h"

#include <algorithm>
#include <cmath>

#include "scslam/apps/evaluate.h"
#include "scslam/core/error.h"

namespace scslam {
namespace {

/// Keyframes of two sessions this near each other count for their relative error.
constexpr double kNear_m = 10;

using Truth = std::vector<std::optional<Pose>>;

/// T_world_base of each keyframe, common base.
Truth truthOf(const SavedMap& map, const Trajectory& truth) {
  const std::string where = map.session().folder().string();
  if (!truth.timed && truth.poses.size() != map.session().scans().size())
    throw inputError("the ground truth of {} has {} poses and no times, the session has {} scans", where,
                     truth.poses.size(), map.session().scans().size());
  const std::size_t first = map.scans().empty() ? 0 : map.scans().front().index;
  Truth result;
  std::size_t found = 0;
  for (const Keyframe& keyframe : map.keyframes()) {
    std::optional<Pose> T_world_own;
    if (truth.timed)
      T_world_own = truth.at(keyframe.stamp);
    else if (keyframe.scan_index - first < truth.poses.size())
      T_world_own = truth.poses[keyframe.scan_index - first].T;
    found += T_world_own ? 1 : 0;
    result.push_back(T_world_own ? std::optional(*T_world_own * map.T_own_base()) : std::nullopt);
  }
  if (found == 0) throw inputError("no keyframe of {} has ground truth: their times have nothing in common", where);
  return result;
}

void judgeLoops(const SessionPair& pair, const Truth& a, const Truth& b, MergedPair& figures) {
  const EvaluationOptions limits;
  std::size_t wrong = 0;
  for (const LoopRecord& loop : pair.loops->records()) {
    if (!loop.accepted || !a[loop.match] || !b[loop.query]) continue;
    const Vector6d error = local(a[loop.match]->inverse() * *b[loop.query], loop.T_match_query);
    wrong += error.head<3>().norm() > limits.loop_trans_m || error.tail<3>().norm() > limits.loop_rot_deg * M_PI / 180;
  }
  figures.false_loops = wrong;
}

void judgePair(const Truth& truth_a, const Truth& truth_b, const std::vector<Pose>& T_map_a,
               const std::vector<Pose>& T_map_b, MergedPair& figures) {
  double square_m2 = 0, square_rad2 = 0;
  std::size_t count = 0;
  for (std::size_t j = 0; j < truth_b.size(); ++j) {
    if (!truth_b[j]) continue;
    double best = kNear_m;
    std::optional<std::size_t> nearest;
    for (std::size_t i = 0; i < truth_a.size(); ++i) {
      if (!truth_a[i]) continue;
      const double d = (truth_a[i]->translation() - truth_b[j]->translation()).norm();
      if (d < best) best = d, nearest = i;
    }
    if (!nearest) continue;
    const Vector6d error = local(truth_a[*nearest]->inverse() * *truth_b[j], T_map_a[*nearest].inverse() * T_map_b[j]);
    square_m2 += error.head<3>().squaredNorm(), square_rad2 += error.tail<3>().squaredNorm();
    ++count;
  }
  if (count == 0) return;
  figures.relative_error_m = std::sqrt(square_m2 / static_cast<double>(count));
  figures.relative_error_deg = std::sqrt(square_rad2 / static_cast<double>(count)) * 180 / M_PI;
}

double ate(const Truth& truth, const std::vector<Pose>& poses, std::vector<Pose>& all_truth,
           std::vector<Pose>& all_poses) {
  std::vector<Pose> with_truth, estimate;
  for (std::size_t k = 0; k < truth.size(); ++k)
    if (truth[k]) with_truth.push_back(*truth[k]), estimate.push_back(poses[k]);
  all_truth.insert(all_truth.end(), with_truth.begin(), with_truth.end());
  all_poses.insert(all_poses.end(), estimate.begin(), estimate.end());
  return absoluteError(with_truth, estimate).rmse_m;
}

}  // namespace

void judgeMerge(const std::vector<SavedMap>& maps, const std::vector<SessionPair>& pairs, const SessionUnion& joined,
                const std::vector<Trajectory>& truths, MergeSummary& summary) {
  std::vector<Truth> truth;
  for (std::size_t s = 0; s < maps.size(); ++s) truth.push_back(truthOf(maps[s], truths[s]));
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const SessionPair& pair = pairs[p];
    judgeLoops(pair, truth[pair.a], truth[pair.b], summary.pairs[p]);
    if (!joined.T_map_base[pair.a].empty() && !joined.T_map_base[pair.b].empty())
      judgePair(truth[pair.a], truth[pair.b], joined.T_map_base[pair.a], joined.T_map_base[pair.b], summary.pairs[p]);
  }
  std::vector<Pose> all_truth, all_poses, ignored_truth, ignored_poses;
  summary.single_ate_rmse_m.resize(maps.size());
  for (std::size_t s = 0; s < maps.size(); ++s) {
    summary.single_ate_rmse_m[s] = ate(truth[s], maps[s].poses(), ignored_truth, ignored_poses);
    if (!joined.T_map_base[s].empty()) ate(truth[s], joined.T_map_base[s], all_truth, all_poses);
  }
  summary.ate_rmse_m = absoluteError(all_truth, all_poses).rmse_m;
}

}  // namespace scslam
