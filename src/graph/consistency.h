// Which loops agree with each other? Pairwise consistency maximisation (Mangelson et al., ICRA 2018): two loops are
// consistent when the cycle of both with the odometry between their ends comes back to where it began; the largest set
// of loops that are all pairwise consistent is believed. A single wrong loop among right ones stays alone. Where
// odometry lost track nothing speaks against a wrong loop: there some must agree before any is believed.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "scslam/core/params.h"
#include "scslam/graph/covariance.h"
#include "scslam/graph/max_clique.h"
#include "scslam/graph/pose_graph.h"

namespace scslam {

struct ConsistencyParams : ParamSetOf<ConsistencyParams> {
  bool enabled = true;
  double gate_chi2 = 22.5;
  double odometry_sigma_per_m = 0.01, odometry_sigma_up_per_m = 0.004, odometry_sigma_deg_per_m = 0.1;
  double loop_sigma_m = 0.1, loop_sigma_deg = 0.5;
  int min_across = 3;
  int budget = 100000;
  void describe(ParamVisitor& visitor) override;
};

/// Grows with the run: nodes as odometry places them, loops as they pass their own gates.
class LoopConsistency {
 public:
  explicit LoopConsistency(const ConsistencyParams& params) : params_(params) {}

  /// @param travelled_m path length up to the node. @param step_covariance of T_previous_this, frame this.
  void addNode(const Pose& T_odom_base, double travelled_m, const Matrix6d& step_covariance, bool planar = false);
  /// Cheap while the loop agrees with all that are believed. @return its number.
  std::size_t addLoop(const Factor& loop);
  /// By loop: is it in the believed set?
  const std::vector<std::uint8_t>& believed() const { return believed_; }
  /// Agrees with the believed ones, but too few join what it joins.
  bool waits(std::size_t loop) const { return chosen_[loop] != 0 && believed_[loop] == 0; }
  /// Of the cycle of two loops, squared Mahalanobis distance from closing (6 degrees of freedom; 3 when planar).
  double disagreement(std::size_t a, std::size_t b) const;

 private:
  struct Node {
    Pose T_odom_base;
    double travelled_m;
    Matrix6d covariance;    ///< of T_first_node along the odometry, frame node
    std::uint32_t stretch;  ///< nodes that odometry followed from one to the next have the same
  };
  struct Loop {
    Factor factor;
    Matrix6d covariance;
  };
  UncertainPose path(std::uint32_t from, std::uint32_t to) const;
  /// The stretches that a loop joins.
  std::pair<std::uint32_t, std::uint32_t> joins(std::size_t loop) const;
  void chooseAmong(std::size_t n, const std::vector<std::uint32_t>& agreeing);
  void believeChosen();

  ConsistencyParams params_;
  std::vector<Node> nodes_;
  std::vector<Loop> loops_;
  BitGraph agree_;
  std::vector<std::uint8_t> chosen_;  ///< by loop: in the largest set
  std::size_t chosen_count_ = 0;
  std::vector<std::uint8_t> believed_;  ///< and not too few across a gap
  bool planar_ = false;
};

}  // namespace scslam
