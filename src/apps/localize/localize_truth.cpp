#include "scslam/apps/localize/localize_truth.h"

#include <algorithm>
#include <cmath>

#include "scslam/apps/alignment.h"
#include "scslam/core/error.h"

namespace scslam {
namespace {

struct Compared {
  std::vector<Pose> truth, estimate;
};

std::optional<Pose> poseAt(const Trajectory& truth, Stamp stamp, std::size_t row) {
  if (truth.timed) return truth.at(stamp);
  return row < truth.poses.size() ? std::optional(truth.poses[row].T) : std::nullopt;
}

/// T_keyframe_base, true and estimated.
Compared fromKeyframes(const std::vector<TrackedScan>& scans, const SavedMap& map, const Trajectory& truth,
                       const Trajectory& session_truth) {
  const std::size_t first = map.scans().empty() ? 0 : map.scans().front().index;
  Compared compared;
  for (const TrackedScan& scan : scans) {
    const Keyframe& keyframe = map.keyframes()[scan.keyframe];
    const auto T_world_base = poseAt(truth, scan.stamp, scan.index);
    const auto T_world_keyframe = poseAt(session_truth, keyframe.stamp, keyframe.scan_index - first);
    if (!T_world_base || !T_world_keyframe) continue;
    compared.truth.push_back(T_world_keyframe->inverse() * *T_world_base);
    compared.estimate.push_back(map.poses()[scan.keyframe].inverse() * scan.T_map_base);
  }
  return compared;
}

/// T_world_base, the map laid on the truth.
Compared laidOn(const std::vector<TrackedScan>& scans, const Trajectory& truth) {
  Compared compared;
  for (const TrackedScan& scan : scans) {
    const auto T_world_base = poseAt(truth, scan.stamp, scan.index);
    if (T_world_base) compared.truth.push_back(*T_world_base), compared.estimate.push_back(scan.T_map_base);
  }
  const Pose T_world_map = alignPoses(compared.truth, compared.estimate, kOrientationLever_m);
  for (Pose& T : compared.estimate) T = T_world_map * T;
  return compared;
}

}  // namespace

LocalizeError localizeError(const std::vector<TrackedScan>& scans, const SavedMap& map,
                            const std::filesystem::path& truth, const std::filesystem::path& session_truth) {
  const bool relative = !session_truth.empty();
  const Trajectory of_input = readTrajectory(truth);
  const Compared compared =
      relative ? fromKeyframes(scans, map, of_input, readTrajectory(session_truth)) : laidOn(scans, of_input);
  if (compared.truth.empty() && !scans.empty())
    throw inputError("no localised scan has ground truth in {}{}{}", truth.string(), relative ? " and " : "",
                     session_truth.string());
  LocalizeError error;
  error.poses = compared.truth.size();
  error.against = relative ? "from the map's keyframe nearby" : "truth laid on the result";
  std::vector<double> metres;
  double square_m2 = 0, square_rad2 = 0;
  for (std::size_t i = 0; i < compared.truth.size(); ++i) {
    const Vector6d d = local(compared.truth[i], compared.estimate[i]);
    const double m = d.head<3>().norm(), rad = d.tail<3>().norm();
    metres.push_back(m);
    square_m2 += m * m, square_rad2 += rad * rad;
    error.max_m = std::max(error.max_m, m);
    error.wrong += m > 1 || rad > 5 * M_PI / 180;
  }
  if (metres.empty()) return error;
  const auto n = static_cast<double>(metres.size());
  error.rmse_m = std::sqrt(square_m2 / n), error.rmse_deg = std::sqrt(square_rad2 / n) * 180 / M_PI;
  std::nth_element(metres.begin(), metres.begin() + static_cast<std::ptrdiff_t>(metres.size() / 2), metres.end());
  error.median_m = metres[metres.size() / 2];
  return error;
}

}  // namespace scslam
