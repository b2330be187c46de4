#include "scslam/apps/trajectory_error.h"

#include <algorithm>
#include <cmath>

#include "scslam/apps/alignment.h"

namespace scslam {

AbsoluteError absoluteError(const std::vector<Pose>& truth, const std::vector<Pose>& estimate) {
  AbsoluteError error;
  error.T_truth_estimate = alignPoses(truth, estimate);
  double sum = 0, level_sum = 0;
  const Pose T_estimate_truth = error.T_truth_estimate.inverse();
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Eigen::Vector3d d = T_estimate_truth * truth[i].translation() - estimate[i].translation();
    sum += d.squaredNorm(), level_sum += d.head<2>().squaredNorm();
    error.max_m = std::max(error.max_m, d.norm());
  }
  if (truth.empty()) return error;
  error.rmse_m = std::sqrt(sum / static_cast<double>(truth.size()));
  error.level_rmse_m = std::sqrt(level_sum / static_cast<double>(truth.size()));
  return error;
}

std::vector<double> travelled(const std::vector<Pose>& poses) {
  std::vector<double> way(poses.size(), 0.0);
  for (std::size_t i = 1; i < poses.size(); ++i)
    way[i] = way[i - 1] + (poses[i].translation() - poses[i - 1].translation()).norm();
  return way;
}

RelativeError relativeError(const std::vector<Pose>& truth, const std::vector<Pose>& estimate) {
  RelativeError error;
  const std::vector<double> way = travelled(truth);
  if (way.empty()) return error;
  const double total = way.back();
  const double unit = total > 100 ? 100 : total > 10 ? 10 : 1;
  const std::size_t step = truth.size() >= 1000 ? 10 : 1;
  double trans = 0, rot = 0;
  for (int multiple = 1; multiple <= 8; ++multiple) {
    const double length = unit * multiple;
    const std::size_t before = error.segments;
    for (std::size_t i = 0; i < truth.size(); i += step) {
      const auto end = std::upper_bound(way.begin() + static_cast<std::ptrdiff_t>(i), way.end(), way[i] + length);
      if (end == way.end()) break;
      const auto j = static_cast<std::size_t>(end - way.begin());
      const Pose difference = (estimate[i].inverse() * estimate[j]).inverse() * (truth[i].inverse() * truth[j]);
      trans += difference.translation().norm() / length;
      rot += rotationAngle(difference) / length;
      ++error.segments;
    }
    if (error.segments > before) error.lengths_m.push_back(length);
  }
  if (error.segments > 0) {
    error.trans_percent = 100 * trans / static_cast<double>(error.segments);
    error.rot_deg_per_m = rot * 180 / M_PI / static_cast<double>(error.segments);
  }
  return error;
}

RelativeError levelRelativeError(const std::vector<Pose>& truth, const std::vector<Pose>& estimate) {
  const Pose T_estimate_truth = alignPoses(truth, estimate).inverse();
  std::vector<Pose> level_truth, level_estimate;
  const auto level = [](const Pose& T) { return poseFromYaw(yawOf(T), {T.translation().x(), T.translation().y(), 0}); };
  for (const Pose& T : truth) level_truth.push_back(level(T_estimate_truth * T));
  for (const Pose& T : estimate) level_estimate.push_back(level(T));
  return relativeError(level_truth, level_estimate);
}

}  // namespace scslam
