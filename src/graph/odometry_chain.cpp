#include "scslam/graph/odometry_chain.h"

#include <algorithm>

namespace scslam {

OdometryChain::OdometryChain(const PoseGraph& graph) : chain_(graph.poses.size()), from_start_(graph.poses.size()) {
  constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::vector<std::uint32_t> step(graph.poses.size(), kNone);  // by its later node
  for (std::uint32_t f = 0; f < graph.factors.size(); ++f) {
    const auto [low, high] = std::minmax(graph.factors[f].i, graph.factors[f].j);
    if (graph.factors[f].kind == FactorKind::kOdometry && high == low + 1 && step[high] == kNone) step[high] = f;
  }
  for (std::uint32_t k = 0; k < graph.poses.size(); ++k) {
    chain_[k] = k;
    if (step[k] == kNone) continue;
    const Factor& factor = graph.factors[step[k]];
    const UncertainPose forward{factor.T_i_j, covarianceOf(factor.information)};
    chain_[k] = chain_[k - 1];
    from_start_[k] = from_start_[k - 1] * (factor.i < factor.j ? forward : inverted(forward));
  }
}

UncertainPose OdometryChain::way(std::uint32_t a, std::uint32_t b) const {
  if (a > b) return inverted(way(b, a));
  UncertainPose result{pose(a, b), {}};
  result.covariance =
      symmetric(from_start_[b].covariance - invertedCovariance(from_start_[a].covariance, result.T_a_b.inverse()));
  return result;
}

}  // namespace scslam
