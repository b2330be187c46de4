// Online optimisation: the graph is the same as before, some poses and factors longer.
//
// A pose that odometry alone leads to needs no solve. Where something else comes in (a loop, a fix), only the poses
// that such factors touch (and every 64th) are variables; the odometry between them is condensed (condensed_chain.h),
// the poses between follow. Gauss-Newton starts where the last solve ended. All nodes are solved instead (the full
// solve) when
//   - more than half of them are variables anyway, or
//   - the ends of a segment turn against the steps between them by more than 0.1 rad, where "first order" ends, or
//   - the condensed solve has not converged.
#pragma once
#include <cstdint>
#include <vector>

#include "scslam/graph/condensed_chain.h"
#include "scslam/graph/graph_solver.h"
#include "scslam/graph/optimiser.h"

namespace scslam {

struct IncrementalSummary {
  std::size_t variables = 0;  ///< poses that were solved for
  bool full = false;
  int iterations = 0;
  bool converged = true;
  std::vector<std::uint32_t> rejected_edges;      ///< loop factors with a weight below 1/2, increasing
  std::vector<std::uint32_t> rejected_positions;  ///< likewise position factors
};

class IncrementalOptimiser {
 public:
  /// Of `params` the kernel and its gate count ("gnc" and "gnc-gm", which look at all loops at once, by Cauchy here).
  explicit IncrementalOptimiser(const OptimiserParams& params);

  /// Solves. Odometry between nodes k and k + 1 must be what it was in the calls before; all other factors may come, go
  /// and change. New poses come in where odometry places them. Deterministic: what happens depends on the graph (its
  /// poses included) alone, not on the calls before.
  IncrementalSummary solve(PoseGraph& graph);

  /// For a graph that has only grown since the last call: solves when what is new contradicts the poses, that is when
  /// the cost of the factors since the last solve, which is the most that another one can gain, exceeds `tolerance`
  /// times that of the graph. @return whether it did.
  bool update(PoseGraph& graph, double tolerance = 0.01);

 private:
  bool solveCondensed(PoseGraph& graph, IncrementalSummary& summary);
  void solveFull(PoseGraph& graph, IncrementalSummary& summary);
  detail::MinimiseResult minimiseInStages(PoseGraph& graph, int max_iterations) const;
  PoseGraph condense(const PoseGraph& graph);
  void spread(const PoseGraph& condensed, PoseGraph& graph) const;
  RobustKernel finalKernel(bool planar) const;
  double gate(bool planar) const;

  OptimiserParams params_;
  detail::CondensedChain chain_;
  std::vector<std::uint8_t> is_step_;  ///< by factor of the graph at hand
  std::vector<std::uint32_t> keys_;    ///< nodes that something else than odometry touches, increasing
  std::vector<std::uint32_t> key_of_;  ///< by node: its place in keys_
  const std::vector<detail::ChainSegment>* segments_ = nullptr;  ///< between keys_
  double cost_ = 0;                                              ///< after the last solve
  double gain_ = 0;                                              ///< what another one may bring at most
};

}  // namespace scslam
