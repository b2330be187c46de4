// The odometry of a pose graph as chains: what it says about the way between two nodes, and how well.
#pragma once
#include <vector>

#include "scslam/graph/covariance.h"

namespace scslam {

class OdometryChain {
 public:
  /// Joins nodes k and k + 1 where an odometry factor leads from one to the other (either way round; the first counts).
  explicit OdometryChain(const PoseGraph& graph);

  bool joined(std::uint32_t a, std::uint32_t b) const { return chain_[a] == chain_[b]; }
  /// T_a_b for joined nodes; the covariance is what the steps between both add up to, to first order.
  UncertainPose way(std::uint32_t a, std::uint32_t b) const;
  /// Without the covariance.
  Pose pose(std::uint32_t a, std::uint32_t b) const { return from_start_[a].T_a_b.inverse() * from_start_[b].T_a_b; }

 private:
  std::vector<std::uint32_t> chain_;  ///< by node: the first node of its chain
  std::vector<UncertainPose> from_start_;
};

}  // namespace scslam
