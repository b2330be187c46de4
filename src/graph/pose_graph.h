// The pose graph: nodes X_i = T_map_base(i) and factors between them (paper, Eq. 2).
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "scslam/core/pose.h"

namespace scslam {

enum class FactorKind : std::uint8_t { kOdometry, kLoop, kPrior };

/// Says X_i^-1 X_j = T_i_j up to `information` (tangent of core/pose.h: translation, rotation vector; right
/// perturbation).
struct Factor {
  FactorKind kind = FactorKind::kOdometry;
  std::uint32_t i = 0, j = 0;  ///< indices into PoseGraph::poses (a prior has i == j and T_i_j = the pose in map)
  Pose T_i_j = Pose::Identity();
  Matrix6d information = Matrix6d::Identity();
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
