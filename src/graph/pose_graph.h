// The pose graph: nodes X_i = T_map_base(i) and factors between them (paper, Eq. 2).
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "scslam/core/pose.h"

namespace scslam {

enum class FactorKind : std::uint8_t {
  kOdometry,  ///< X_i^-1 X_j = T_i_j
  kLoop,      ///< the same, and robust kernels apply
  kPrior,     ///< X_j = T_i_j (i == j)
  /// X_i^-1 X_j arm = translation of T_i_j: a point of node j (an antenna) as measured in the frame that node i is (the
  /// satellites' east-north-up, which then is a node of the graph). Information: upper left 3x3, axes of i; robust.
  kPosition,
  kGravity,  ///< X_j turns `arm`, up as measured in frame j, into up of the map (i == j). Information: lower right 3x3.
};
inline constexpr bool isRelative(FactorKind kind) { return kind == FactorKind::kOdometry || kind == FactorKind::kLoop; }
inline constexpr bool isUnary(FactorKind kind) { return kind == FactorKind::kPrior || kind == FactorKind::kGravity; }
/// Robust kernels apply to what may be plain wrong.
inline constexpr bool isRobust(FactorKind kind) { return kind == FactorKind::kLoop || kind == FactorKind::kPosition; }

/// A measurement with its `information` (tangent of core/pose.h: translation, rotation vector; right perturbation).
struct Factor {
  FactorKind kind = FactorKind::kOdometry;
  std::uint32_t i = 0, j = 0;  ///< indices into PoseGraph::poses
  Pose T_i_j = Pose::Identity();
  Matrix6d information = Matrix6d::Identity();
  Eigen::Vector3d arm = Eigen::Vector3d::Zero();  ///< of positions and gravity alone
};

struct PoseGraph {
  std::vector<Pose> poses;
  std::vector<Factor> factors;
  std::vector<std::int64_t> ids;  ///< the file's own vertex ids, empty = 0, 1, 2, …
  bool planar = false;            ///< SE(2) data lifted to SE(3): chi2 counts (x, y, yaw) only
  /// Nodes the optimiser holds at their pose (g2o's FIX). A part of the graph without one is held by its priors,
  /// without those by its first node.
  std::vector<std::uint32_t> fixed;
};

}  // namespace scslam
