#include "scslam/graph/relative_covariance.h"

#include "scslam/graph/block_cholesky.h"
#include "scslam/graph/covariance.h"
#include "scslam/graph/normal_equations.h"

namespace scslam::detail {
namespace {

template <int B>
struct Factored {
  Factored(const PoseGraph& graph, const GraphStructure& structure, const Weighting& weighting)
      : cholesky(structure.symbolic) {
    NormalEquations<B> equations(structure);
    equations.linearise(graph, structure, weighting);
    known = cholesky.factor(equations.blocks, 0);
  }

  Matrix6d spread(std::uint32_t vi, const Matrix6d& J_i, std::uint32_t vj, const Matrix6d& J_j) {
    const auto reduced = cholesky.spread(vi, NormalEquations<B>::reduced(J_i), vj, NormalEquations<B>::reduced(J_j));
    if constexpr (B == 6) {
      return reduced;
    } else {
      Matrix6d full = Matrix6d::Zero();
      for (int r = 0; r < B; ++r)
        for (int c = 0; c < B; ++c) full(kPlanarAxes[r], kPlanarAxes[c]) = reduced(r, c);
      return full;
    }
  }

  BlockCholesky<B> cholesky;
  bool known;
};

}  // namespace

struct RelativeCovariance::State {
  const PoseGraph& graph;
  const GraphStructure& structure;
  std::unique_ptr<Factored<6>> spatial;
  std::unique_ptr<Factored<3>> planar;
};

RelativeCovariance::RelativeCovariance(const PoseGraph& graph, const GraphStructure& structure,
                                       const Weighting& weighting)
    : state_(std::make_unique<State>(State{graph, structure, nullptr, nullptr})) {
  if (graph.planar)
    state_->planar = std::make_unique<Factored<3>>(graph, structure, weighting);
  else
    state_->spatial = std::make_unique<Factored<6>>(graph, structure, weighting);
}
RelativeCovariance::~RelativeCovariance() = default;

bool RelativeCovariance::known() const { return state_->planar ? state_->planar->known : state_->spatial->known; }

double RelativeCovariance::innovation(const Factor& factor) {
  const PoseGraph& graph = state_->graph;
  Matrix6d J_i, J_j;
  const Vector6d r = factorError(factor, graph.poses[factor.i], graph.poses[factor.j], J_i, J_j);
  const std::uint32_t vi = state_->structure.variable[factor.i], vj = state_->structure.variable[factor.j];
  const Matrix6d known =
      graph.planar ? state_->planar->spread(vi, J_i, vj, J_j) : state_->spatial->spread(vi, J_i, vj, J_j);
  return mahalanobis2(r, covarianceOf(factor.information) + known, graph.planar);
}

}  // namespace scslam::detail
