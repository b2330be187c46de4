// Levenberg-Marquardt on a pose graph with the block-sparse Cholesky factorisation: what the time goes into.
#pragma once
#include <memory>
#include <vector>

#include "scslam/graph/block_symbolic.h"
#include "scslam/graph/components.h"
#include "scslam/graph/robust_kernel.h"

namespace scslam::detail {

/// Variables and sparsity of a graph: the same for every stage of one optimisation.
struct GraphStructure {
  static constexpr std::uint32_t kHeld = ~std::uint32_t{0};

  /// @param used by factor: those with 0 get no block (all are used when empty). Parts are those of the whole graph.
  explicit GraphStructure(const PoseGraph& graph, const std::vector<std::uint8_t>& used = {});

  GraphParts parts;
  std::vector<std::uint32_t> variable;  ///< by node, kHeld for those that do not move
  std::uint32_t variables = 0;
  std::vector<std::uint32_t> block;  ///< by factor: its off-diagonal block in BlockSymbolic's numbering, kHeld if none
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  std::shared_ptr<const BlockSymbolic> symbolic;
};

/// How factors count: fixed weights (all 1 when empty; 0 takes a factor out), and a kernel on the robust ones.
struct Weighting {
  RobustKernel kernel;
  std::vector<double> weights;
  double cost(const PoseGraph& graph) const;
  double costOf(const PoseGraph& graph, std::size_t factor) const;
};

struct MinimiseOptions {
  int max_iterations = 50;
  /// Stops when a step promises less than this share of the cost (or less than `negligible`).
  double relative_decrease = 1e-7;
  double negligible = 1e-12;
  /// Stops also when a step gained what it promised, up to that share: what the linear model left out is about what
  /// there is left to gain. Saves the step that only confirms it.
  bool trust_model = false;
};

struct MinimiseResult {
  int iterations = 0;
  bool converged = false;
  double cost = 0;
};

/// Starts with full Gauss-Newton steps (infinite trust) and damps only when a step fails; graph.poses end at the lowest
/// cost seen. Never throws; a singular graph ends unconverged where the damping no longer helps.
MinimiseResult minimise(PoseGraph& graph, const GraphStructure& structure, const Weighting& weighting,
                        const MinimiseOptions& options);

}  // namespace scslam::detail
