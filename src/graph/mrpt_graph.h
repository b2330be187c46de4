// Our pose graph as MRPT's, for everything MRPT can do with one. MRPT's edges are Gaussians over (x y z yaw pitch
// roll), ours over SE(3) tangents; core/mrpt_pose.h converts each.
#pragma once
#include <mrpt/graphs/CNetworkOfPoses.h>

#include "scslam/graph/pose_graph.h"

namespace scslam {

/// Node ids are graph.ids (0, 1, … when empty); the root is the first node. Priors have no place in MRPT's graph and
/// are left out. @throw inputError when an id is negative or does not fit MRPT's 64 bits.
mrpt::graphs::CNetworkOfPoses3DInf toMrpt(const PoseGraph& graph);

/// The inverse; ids are kept, indices follow increasing ids. Neighbours in that order count as odometry, other edges as
/// loops. Edges whose nodes have no pose get identity poses. @throw inputError for edges that MRPT stores inverted
/// (edges_store_inverse_poses).
PoseGraph fromMrpt(const mrpt::graphs::CNetworkOfPoses3DInf& network);

}  // namespace scslam
