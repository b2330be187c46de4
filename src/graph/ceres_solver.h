// The same problem for Ceres: its Levenberg-Marquardt takes over where our own does not converge, and tests compare
// both.
#pragma once
#include "scslam/graph/graph_solver.h"

namespace scslam::detail {

/// Poses as (translation, quaternion) blocks with our right-perturbation manifold, analytic Jacobians, kernels as
/// Ceres losses on the loop factors. Graph poses end at Ceres' solution.
MinimiseResult minimiseWithCeres(PoseGraph& graph, const GraphStructure& structure, const Weighting& weighting,
                                 const MinimiseOptions& options);

}  // namespace scslam::detail
