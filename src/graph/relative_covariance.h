// How well does the rest of the graph know what a factor measures?
#pragma once
#include <memory>

#include "scslam/graph/graph_solver.h"

namespace scslam::detail {

class RelativeCovariance {
 public:
  /// Linearises at graph.poses with the factors that `structure` has blocks for and `weighting` gives a weight.
  RelativeCovariance(const PoseGraph& graph, const GraphStructure& structure, const Weighting& weighting);
  ~RelativeCovariance();

  /// False where the graph does not determine every pose: nothing can be said then.
  bool known() const;
  /// r^T (Lambda^-1 + J H^-1 J^T)^-1 r of a factor that is not part of the linearised graph: its innovation. Of
  /// chi-square distribution when it is true, however far the poses have drifted.
  double innovation(const Factor& factor);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scslam::detail
