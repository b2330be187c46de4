#include "scslam/apps/evaluate.h"

#include <cmath>

#include "scslam/apps/loop_figures.h"
#include "scslam/core/error.h"

namespace scslam {
namespace {

std::vector<std::optional<Pose>> associate(const std::vector<ScanRecord>& scans, const Trajectory& truth,
                                           const EvaluationOptions& options) {
  std::vector<std::optional<Pose>> T_truth_base(scans.size());
  if (!truth.timed && truth.poses.size() != scans.size())
    throw inputError(
        "the ground truth has {} poses and no times, the session has {} scans: row i can only belong to "
        "scan i when both agree; give a TUM file (with times)",
        truth.poses.size(), scans.size());
  std::size_t found = 0;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    T_truth_base[i] =
        truth.timed ? truth.at(scans[i].stamp, options.stamp_tolerance_s) : std::optional(truth.poses[i].T);
    found += T_truth_base[i] ? 1 : 0;
  }
  if (found == 0 && !scans.empty())
    throw inputError("no scan has ground truth: the scans span {} … {} s, the truth {} … {} s",
                     formatStamp(scans.front().stamp), formatStamp(scans.back().stamp),
                     formatStamp(truth.poses.front().stamp), formatStamp(truth.poses.back().stamp));
  return T_truth_base;
}

/// What of `T` has truth, and that truth.
struct Pairs {
  std::vector<Pose> truth, estimate;
  void add(const std::optional<Pose>& T_truth_base, const Pose& T) {
    if (T_truth_base) truth.push_back(*T_truth_base), estimate.push_back(T);
  }
};

std::string describeAlignment(std::size_t poses) {
  if (poses < 3) return fmt::format("SE(3) over {} pose{}, orientation included", poses, poses == 1 ? "" : "s");
  return fmt::format("SE(3) least squares (Umeyama, no scale) over {} positions", poses);
}

}  // namespace

Evaluation evaluate(const Session& session, const Trajectory& truth, const EvaluationOptions& options) {
  if (session.scans().empty()) throw inputError("{} holds no scans to evaluate", session.folder().string());
  Evaluation result;
  result.T_truth_base = associate(session.scans(), truth, options);
  const auto corrected = session.trajectory(), odometry = session.odometry();
  Pairs after, before, keyframes;
  std::vector<std::optional<Pose>> T_truth_keyframe(session.keyframes().size());
  for (std::size_t i = 0; i < corrected.size(); ++i) {
    after.add(result.T_truth_base[i], corrected[i].T);
    before.add(result.T_truth_base[i], odometry[i].T);
    const auto k = static_cast<std::size_t>(session.scans()[i].keyframe);
    if (session.scans()[i].keyframe < 0 || k >= T_truth_keyframe.size()) continue;
    if (session.keyframes()[k].scan_index != session.scans()[i].index) continue;
    T_truth_keyframe[k] = result.T_truth_base[i];
    keyframes.add(result.T_truth_base[i], session.poses()[k]);
  }
  result.poses = after.truth.size();
  result.scans = corrected.size();
  result.planar = !session.keyframes().empty() && session.keyframes().front().planar;
  result.ate = absoluteError(after.truth, after.estimate);
  result.odometry_ate = absoluteError(before.truth, before.estimate);
  result.keyframe_ate = absoluteError(keyframes.truth, keyframes.estimate);
  result.rpe = relativeError(after.truth, after.estimate);
  result.odometry_rpe = relativeError(before.truth, before.estimate);
  if (result.planar) {
    result.level_rpe = levelRelativeError(after.truth, after.estimate);
    result.odometry_level_rpe = levelRelativeError(before.truth, before.estimate);
  }
  result.alignment = describeAlignment(result.poses);
  result.loops = loopFigures(session.loops(), T_truth_keyframe, options);
  return result;
}

}  // namespace scslam
