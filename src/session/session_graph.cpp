#include "scslam/session/session_graph.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace scslam {
namespace {

Matrix6d informationOf(const Matrix6d& covariance) {
  const Eigen::LLT<Matrix6d> llt(covariance);
  if (llt.info() == Eigen::Success && covariance.allFinite() && covariance.diagonal().minCoeff() > 1e-14) {
    const Matrix6d information = llt.solve(Matrix6d::Identity());
    return (information + information.transpose()) / 2;
  }
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(0.05), Eigen::Vector3d::Constant(0.5 * M_PI / 180);
  return sigma.cwiseProduct(sigma).cwiseInverse().asDiagonal();
}

}  // namespace

PoseGraph buildGraph(const std::vector<Keyframe>& keyframes, const std::vector<LoopRecord>& loops,
                     const std::vector<Pose>& T_map_base, bool planar) {
  PoseGraph graph;
  graph.planar = planar;
  graph.poses = T_map_base;
  for (std::size_t k = 1; k < keyframes.size(); ++k) {
    if (keyframes[k].step_covariance(0, 0) >= kOpenStep) continue;
    const Pose T_i_j = keyframes[k - 1].T_odom_base.inverse() * keyframes[k].T_odom_base;
    graph.factors.push_back({FactorKind::kOdometry, static_cast<std::uint32_t>(k - 1), static_cast<std::uint32_t>(k),
                             T_i_j, informationOf(keyframes[k].step_covariance)});
  }
  for (const LoopRecord& loop : loops)
    if (loop.accepted)
      graph.factors.push_back({FactorKind::kLoop, loop.match, loop.query, loop.T_match_query, loop.information});
  return graph;
}

PoseGraph graphOfSensor(PoseGraph graph, const Pose& T_base_sensor) {
  if (T_base_sensor.isApprox(Pose::Identity(), 0)) return graph;
  // S^-1 T Exp(d_base) S = S^-1 T S Exp(d_sensor) with d_base = adjoint(S) d_sensor.
  const Matrix6d J = adjoint(T_base_sensor);
  const Pose T_sensor_base = T_base_sensor.inverse();
  for (Pose& T : graph.poses) T = T * T_base_sensor;
  for (Factor& factor : graph.factors) {
    factor.T_i_j =
        factor.kind == FactorKind::kPrior ? factor.T_i_j * T_base_sensor : T_sensor_base * factor.T_i_j * T_base_sensor;
    factor.information = J.transpose() * factor.information * J;
    factor.information = ((factor.information + factor.information.transpose()) / 2).eval();
  }
  return graph;
}

std::vector<StampedPose> correctedTrajectory(const std::vector<ScanRecord>& scans,
                                             const std::vector<Keyframe>& keyframes,
                                             const std::vector<Pose>& T_map_base) {
  std::vector<StampedPose> trajectory;
  trajectory.reserve(scans.size());
  std::int64_t corrected = -1;
  Pose T_map_odom = Pose::Identity();
  for (const ScanRecord& scan : scans) {
    // The journal of a killed run may end between a scan and the keyframe it became.
    const std::int64_t k = std::min<std::int64_t>(scan.keyframe, static_cast<std::int64_t>(keyframes.size()) - 1);
    if (k >= 0 && k != corrected) {
      const auto i = static_cast<std::size_t>(k);
      T_map_odom = T_map_base[i] * keyframes[i].T_odom_base.inverse();
      corrected = k;
    }
    trajectory.push_back({scan.stamp, k < 0 ? scan.T_odom_base : T_map_odom * scan.T_odom_base});
  }
  return trajectory;
}

std::vector<StampedPose> odometryTrajectory(const std::vector<ScanRecord>& scans) {
  std::vector<StampedPose> trajectory;
  trajectory.reserve(scans.size());
  for (const ScanRecord& scan : scans) trajectory.push_back({scan.stamp, scan.T_odom_base});
  return trajectory;
}

}  // namespace scslam
