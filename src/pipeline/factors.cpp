#include "scslam/pipeline/factors.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "scslam/graph/covariance.h"

namespace scslam {
namespace {

Matrix6d floorCovariance(double floor_m, double floor_deg) {
  const double t = floor_m * floor_m, r = std::pow(floor_deg * M_PI / 180, 2);
  return Vector6d(t, t, t, r, r, r).asDiagonal();
}

}  // namespace

Matrix6d withFloor(const Matrix6d& information, double floor_m, double floor_deg) {
  const Matrix6d F = floorCovariance(floor_m, floor_deg);
  return symmetric(information * (Matrix6d::Identity() + F * information).inverse());
}

Pose appendNode(PoseGraph& graph, const std::vector<Keyframe>& keyframes, const Keyframe& keyframe,
                const GraphParams& params) {
  const auto j = static_cast<std::uint32_t>(graph.poses.size());
  graph.planar = keyframe.planar;
  if (j == 0) {
    graph.poses.push_back(keyframe.T_odom_base);
    return graph.poses.back();
  }
  graph.factors.push_back(odometryFactor(keyframes.back(), keyframe, j - 1, j, params));
  graph.poses.push_back(graph.poses.back() * graph.factors.back().T_i_j);
  return graph.poses.back();
}

Factor odometryFactor(const Keyframe& earlier, const Keyframe& later, std::uint32_t i, std::uint32_t j,
                      const GraphParams& params) {
  const Matrix6d covariance =
      symmetric(later.step_covariance) + floorCovariance(params.odometry_floor_m, params.odometry_floor_deg);
  return {FactorKind::kOdometry, i, j, earlier.T_odom_base.inverse() * later.T_odom_base,
          symmetric(covariance.inverse())};
}

Matrix6d loopInformation(const LoopRecord& record, const GraphParams& params) {
  const double growth = std::max(1.0, std::pow((1 - record.inlier_ratio) / params.loop_outliers, 2));
  return withFloor(record.information, growth * params.loop_floor_m, growth * params.loop_floor_deg);
}

Factor loopFactor(const LoopRecord& record, const GraphParams& params) {
  return {FactorKind::kLoop, record.match, record.query, record.T_match_query, loopInformation(record, params)};
}

}  // namespace scslam
