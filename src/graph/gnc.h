// Graduated non-convexity over a set of trusted loops that grows and shrinks: which loops are true?
//
// 1. Loops that neighbours support (loop_support.h) are tried first, and those without which the graph would fall
// apart.
// 2. Cauchy from the best start, then graduated non-convexity (Yang et al., RA-L 2020) sorts them into true and false;
//    the false leave the structure, so that what they joined costs nothing from then on.
// 3. The a-posteriori variance factor shows whether the information matrices are too modest (by orders of magnitude in
//    public graphs); then the gate, which is in units of theirs, is made as much narrower.
// 4. What was left out gets another chance: a loop whose error at the solution lies within the gate, or whose
//    innovation (relative_covariance.h) does: a lone loop after a long drift. Back to 2 until nothing changes.
#pragma once
#include <string>
#include <vector>

#include "scslam/graph/optimiser.h"
#include "scslam/graph/pose_graph.h"

namespace scslam::detail {

struct GncResult {
  std::vector<double> weights;  ///< by factor; 0 for what is rejected
  std::string start;
  double chi2_start = 0, gate = 0;
  int iterations = 0;
  bool converged = false;
};

/// params.robust is "gnc" (truncated least squares) or "gnc-gm" (Geman-McClure); params.gate_chi2 = 0 lets step 3
/// happen.
GncResult runGnc(PoseGraph& graph, const OptimiserParams& params);

}  // namespace scslam::detail
