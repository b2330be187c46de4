// From what was measured to factors of the pose graph (paper, Eq. 2), with honest weights.
#pragma once
#include "scslam/pipeline/slam_params.h"
#include "scslam/session/records.h"

namespace scslam {

/// Adds the node of `keyframe`, placed by odometry after the newest of `keyframes`, and the odometry factor between
/// both; the first node stands at its odometry pose (the optimiser holds it there: the gauge).
/// @return the node's pose T_map_base.
Pose appendNode(PoseGraph& graph, const std::vector<Keyframe>& keyframes, const Keyframe& keyframe,
                const GraphParams& params);

/// The odometry between two keyframes, which are the graph's nodes i and j.
Factor odometryFactor(const Keyframe& earlier, const Keyframe& later, std::uint32_t i, std::uint32_t j,
                      const GraphParams& params);

/// Information of the loop's T_match_query: the registration's, never better than the floor. The floor grows with the
/// square of the share of outliers: they say how much of the fit is other surfaces that resemble these (storeys,
/// ramps), an error the Hessian knows nothing of.
Matrix6d loopInformation(const LoopRecord& record, const GraphParams& params);

/// X_match^-1 X_query = T_match_query, weighted by loopInformation.
Factor loopFactor(const LoopRecord& record, const GraphParams& params);

/// Information of a measurement whose own information is `information` after independent noise with standard deviations
/// floor_m, floor_deg is added: (I^-1 + F)^-1, defined for singular I too.
Matrix6d withFloor(const Matrix6d& information, double floor_m, double floor_deg);

}  // namespace scslam
