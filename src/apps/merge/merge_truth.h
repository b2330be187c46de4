// A merge against the truth.
#pragma once
#include <vector>

#include "scslam/apps/merge/union_graph.h"

namespace scslam {

/// Fills the figures that need truth. @param truths by session: T_world_base of its own base, all in one world frame.
/// @throw inputError when a truth does not belong to its session.
void judgeMerge(const std::vector<SavedMap>& maps, const std::vector<SessionPair>& pairs, const SessionUnion& joined,
                const std::vector<Trajectory>& truths, MergeSummary& summary);

}  // namespace scslam
