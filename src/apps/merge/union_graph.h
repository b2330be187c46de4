// The sessions that hang together, as one pose graph.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "scslam/apps/merge/pair_loops.h"

namespace scslam {

struct SessionPair {
  std::size_t a = 0, b = 0;  ///< sessions, a < b
  std::unique_ptr<PairLoops> loops;
  std::string refusal;  ///< empty: their loops join them
};

/// One frame for some sessions.
struct SessionUnion {
  std::vector<std::size_t> members;                ///< sessions, increasing; the first one's map frame is the union's
  std::vector<std::vector<Pose>> T_map_base;       ///< by session; empty where it is no member
  std::vector<std::vector<LoopRecord>> own_loops;  ///< by session: its loops as judged now
  PoseGraph graph;                                 ///< nodes = the members' keyframes; odometry and accepted loops
};

/// Sessions joined by pairs, as lists of sessions; the largest (by keyframes, then the first) first.
std::vector<std::vector<std::size_t>> connectedSessions(const std::vector<SavedMap>& maps,
                                                        const std::vector<SessionPair>& pairs);

/// Places the members by the pairs with the most loops (each session's frame hangs on an anchor), then solves for all
/// of their keyframes: odometry, satellite fixes, the sessions' own loops and those between them, robustly. Loops the
/// graph refuses lose their verdict.
SessionUnion solveUnion(const std::vector<SavedMap>& maps, std::vector<SessionPair>& pairs,
                        const std::vector<std::size_t>& members, const SlamParams& slam);

}  // namespace scslam
