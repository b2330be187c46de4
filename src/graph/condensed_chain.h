// Odometry condensed: between two poses that something else than odometry touches, the chain of steps is one factor.
// The poses between are no variables; they follow from the two ends.
#pragma once
#include <vector>

#include "scslam/graph/covariance.h"

namespace scslam::detail {

/// A stretch of odometry between two nodes, first order in the noise of its steps.
struct ChainSegment {
  std::uint32_t begin, end;
  Pose T_begin_end = Pose::Identity();
  Matrix6d information = Matrix6d::Zero();  ///< of T_begin_end
  struct Inner {
    Pose T_begin_this;
    Matrix6d gain;  ///< expected error of this pose for an error of T_begin_end
  };
  std::vector<Inner> inner;  ///< of the nodes between begin and end

  /// (translation, rotation vector) by which the ends contradict the steps between them.
  Vector6d error(const std::vector<Pose>& poses) const;
  /// Moves the poses between the ends to where they are most likely, given the ends.
  void placeInner(std::vector<Pose>& poses) const;
};

/// Grows with the graph; every step is composed once as long as the ends of its segment stay the same.
class CondensedChain {
 public:
  /// Takes the odometry steps of a graph: factors between nodes k and k + 1, the first of each pair. A step that was
  /// there before is taken to be unchanged. @param is_step by factor: is it one? As long as the factors that are known;
  /// those from there on are looked at (empty: all).
  void takeSteps(const PoseGraph& graph, std::vector<std::uint8_t>& is_step);
  /// Does a step lead from node - 1 to node?
  bool joined(std::uint32_t node) const { return steps_[node].present; }
  /// T_before_node of a node that is joined to the one before.
  const Pose& step(std::uint32_t node) const { return steps_[node].way.T_a_b; }
  /// The segments between neighbours of `keys` (increasing) that steps join without a gap.
  const std::vector<ChainSegment>& segmentsBetween(const std::vector<std::uint32_t>& keys, bool planar);

 private:
  struct Step {
    bool present = false;  ///< in the graph at hand
    bool known = false;    ///< the rest is filled in
    UncertainPose way;
    Matrix6d information = Matrix6d::Zero();
  };
  ChainSegment condensed(std::uint32_t begin, std::uint32_t end, bool planar) const;

  std::vector<Step> steps_;  ///< by their later node
  std::vector<ChainSegment> segments_;
};

}  // namespace scslam::detail
