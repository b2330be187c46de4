// One stage of an optimisation by the solver the user chose.
#pragma once
#include "scslam/graph/graph_solver.h"
#include "scslam/graph/optimiser.h"

namespace scslam::detail {

/// Own solver, Ceres where that stalls; or Ceres alone.
MinimiseResult descend(PoseGraph& graph, const GraphStructure& structure, const Weighting& weighting,
                       const OptimiserParams& params);

}  // namespace scslam::detail
