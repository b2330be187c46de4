// Pose-graph optimisation: where to start, how to descend, which loops to believe.
#pragma once
#include <string>
#include <vector>

#include "scslam/core/params.h"
#include "scslam/graph/pose_graph.h"

namespace scslam {

struct OptimiserParams : ParamSetOf<OptimiserParams> {
  std::string init = "auto";
  std::string robust = "none";
  double gate_chi2 = 0;
  int max_iterations = 50;
  double relative_decrease = 1e-7;
  std::string solver = "auto";

  void describe(ParamVisitor& v) override;
};

struct OptimiserSummary {
  double chi2_initial = 0;  ///< sum of r^T Lambda r over all factors, no 1/2, of the poses as they came
  double chi2_start = 0;    ///< of the start that was chosen
  double chi2_final = 0;
  int iterations = 0;  ///< linear systems solved, all stages together
  bool converged = false;
  double gate_chi2 = 0;                           ///< at which a loop counted as false
  std::string start;                              ///< "file", "spanning" or "chordal"
  std::vector<double> weights;                    ///< by factor, in [0, 1]; all 1 without a robust kernel
  std::vector<std::uint32_t> rejected_edges;      ///< loop factors that end with a weight below 1/2, increasing
  std::vector<std::uint32_t> rejected_positions;  ///< likewise position factors
  std::size_t parts = 0;                          ///< connected parts; each has a gauge of its own
  std::string floating;                           ///< one line about unconnected parts, empty when there is one part
};

/// Moves graph.poses to the lowest cost found: residual E = Z^-1 X_i^-1 X_j, r = (translation, rotation vector of E),
/// cost = sum of rho(r^T Lambda r), rho on loop and position factors only. SE(2) graphs move in (x, y, yaw) and stay
/// planar.
///
/// With init = "file" and a good start (online use) this is one or two Gauss-Newton steps. The result does not depend
/// on threads or time. Never throws for ill-posed graphs: directions that nothing fixes stay where they were.
/// @throw usageError for a parameter value that is not one of its choices.
OptimiserSummary optimise(PoseGraph& graph, const OptimiserParams& params = {});

/// The choices of OptimiserParams::robust.
const std::vector<std::string>& robustChoices();

/// Poses along the spanning tree with the fewest edges to each node, from each part's anchor: for graphs without poses.
void placeAlongSpanningTree(PoseGraph& graph);

}  // namespace scslam
