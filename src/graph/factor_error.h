// The error of a factor and its derivatives; every cost of this program is a sum of r^T Lambda r of these.
#pragma once
#include <vector>

#include "scslam/graph/pose_graph.h"

namespace scslam {

/// r = (translation of E, rotation vector of E), E = Z^-1 X_i^-1 X_j. A prior has X_i = identity. Positions and gravity
/// have three rows of their own (FactorKind), the others are zero.
Vector6d factorError(const Factor& factor, const Pose& X_i, const Pose& X_j);

/// The same with the derivatives to right perturbations of X_i and X_j (core/pose.h retract). Where i == j, J_i is
/// zero.
Vector6d factorError(const Factor& factor, const Pose& X_i, const Pose& X_j, Matrix6d& J_i, Matrix6d& J_j);

/// r^T Lambda r of one factor; in a planar graph over (x, y, yaw) only.
double factorChi2(const PoseGraph& graph, const Factor& factor);
/// Sum over all factors, no 1/2.
double graphChi2(const PoseGraph& graph);

/// The rows of (x y z, rotation vector) that an SE(2) graph keeps.
inline constexpr int kPlanarAxes[3] = {0, 1, 5};

}  // namespace scslam
