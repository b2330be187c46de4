// Where the optimisation starts.
#pragma once
#include "scslam/graph/graph_solver.h"

namespace scslam::detail {

/// Every pose along a spanning tree from its part's anchor (which stays, or takes its prior's pose).
/// @param odometry_first walks loop factors only where no odometry leads (for graphs with false loops); else the tree
/// with the fewest edges to each node.
/// Factors of weight 0 do not count (all weights are 1 when empty).
void spanningTree(PoseGraph& graph, const GraphParts& parts, bool odometry_first,
                  const std::vector<double>& weights = {});

/// Chordal initialisation (Carlone et al., ICRA 2015): rotations by linear least squares over unconstrained 3x3
/// matrices, each projected onto SO(3); then translations, linear given the rotations. Not iterative, needs no guess.
/// Factors count with `weights` (all 1 when empty). @return false (graph untouched) when a system is singular.
bool chordal(PoseGraph& graph, const GraphStructure& structure, const std::vector<double>& weights = {});

/// Moves graph.poses to the start of the lowest cost under `judge`; ties keep the earlier one. @param init "auto" tries
/// the graph's own poses ("file"), "spanning" and "chordal", else the one it names. @return the one taken.
std::string chooseStart(PoseGraph& graph, const GraphStructure& structure, const std::string& init,
                        const Weighting& judge, bool odometry_first);

}  // namespace scslam::detail
