#include "scslam/graph/consistency.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "scslam/graph/covariance.h"

namespace scslam {
namespace {

Matrix6d diagonal(double level_m, double up_m, double turn_rad) {
  Vector6d v;
  v << level_m * level_m, level_m * level_m, up_m * up_m, Eigen::Vector3d::Constant(turn_rad * turn_rad);
  return v.asDiagonal();
}

}  // namespace

void ConsistencyParams::describe(ParamVisitor& v) {
  v.field("enabled", enabled, "only loops that agree with each other enter the graph");
  v.field("gate_chi2", gate_chi2, "two loops agree when their cycle's chi2 is below this (22.5: 99.9 %, 6 dof)", 0,
          1e9);
  v.field("odometry_sigma_per_m", odometry_sigma_per_m, "odometry between both: at least this, one sigma [m/m]", 0, 10);
  v.field("odometry_sigma_up_per_m", odometry_sigma_up_per_m, "and in height this [m/m]", 0, 10);
  v.field("odometry_sigma_deg_per_m", odometry_sigma_deg_per_m, "and this angle [deg/m]", 0, 90);
  v.field("loop_sigma_m", loop_sigma_m, "a loop is not trusted better than this, one sigma [m]", 1e-6, 100);
  v.field("loop_sigma_deg", loop_sigma_deg, "and this [deg]", 1e-6, 180);
  v.field("min_across", min_across, "loops that must agree before they join what odometry could not follow", 1, 1000);
  v.field("budget", budget, "branches of the search for the largest set at most, per loop", 1, 1000000000);
}

void LoopConsistency::addNode(const Pose& T_odom_base, double travelled_m, const Matrix6d& step_covariance,
                              bool planar) {
  planar_ = planar;
  Matrix6d covariance = Matrix6d::Zero();
  if (!nodes_.empty())
    covariance = symmetric(composeCovariance(nodes_.back().covariance,
                                             nodes_.back().T_odom_base.inverse() * T_odom_base, step_covariance));
  const std::uint32_t stretch =
      nodes_.empty() ? 0 : nodes_.back().stretch + (levelSigma(step_covariance) > kLostTrack_m ? 1 : 0);
  nodes_.push_back({T_odom_base, travelled_m, covariance, stretch});
}

/// T_from_to along the odometry: what the way to `to` adds to the way to `from`.
UncertainPose LoopConsistency::path(std::uint32_t from, std::uint32_t to) const {
  const bool forward = from <= to;
  const Node& a = nodes_[forward ? from : to];
  const Node& b = nodes_[forward ? to : from];
  UncertainPose way{a.T_odom_base.inverse() * b.T_odom_base, {}};
  const double travelled = b.travelled_m - a.travelled_m;
  way.covariance = symmetric(b.covariance - invertedCovariance(a.covariance, way.T_a_b.inverse())) +
                   diagonal(params_.odometry_sigma_per_m * travelled, params_.odometry_sigma_up_per_m * travelled,
                            params_.odometry_sigma_deg_per_m * M_PI / 180 * travelled);
  return forward ? way : inverted(way);
}

double LoopConsistency::disagreement(std::size_t a, std::size_t b) const {
  const Factor &one = loops_[a].factor, &two = loops_[b].factor;
  return cycleChi2({one.T_i_j, loops_[a].covariance}, path(one.j, two.j), {two.T_i_j, loops_[b].covariance},
                   path(two.i, one.i), planar_);
}

std::size_t LoopConsistency::addLoop(const Factor& loop) {
  const double turn = params_.loop_sigma_deg * M_PI / 180;
  loops_.push_back({loop, covarianceOf(loop.information) + diagonal(params_.loop_sigma_m, params_.loop_sigma_m, turn)});
  const std::size_t n = loops_.size() - 1;
  std::vector<std::uint32_t> agreeing;
  for (std::uint32_t other = 0; other < n; ++other)
    if (disagreement(other, n) <= params_.gate_chi2) agreeing.push_back(other);
  agree_.add(agreeing);
  chosen_.push_back(0);
  chooseAmong(n, agreeing);
  believeChosen();
  return n;
}

void LoopConsistency::chooseAmong(std::size_t n, const std::vector<std::uint32_t>& agreeing) {
  const auto with_chosen = static_cast<std::size_t>(
      std::count_if(agreeing.begin(), agreeing.end(), [this](std::uint32_t k) { return chosen_[k] != 0; }));
  if (with_chosen == chosen_count_) {  // one more than the largest so far cannot be beaten
    chosen_[n] = 1;
    ++chosen_count_;
    return;
  }
  // A larger set than the chosen one must contain the new loop, and otherwise only what agrees with it.
  const CliqueResult found = maxClique(agree_, agreeing, chosen_count_ - 1, static_cast<std::size_t>(params_.budget));
  if (found.nodes.empty()) return;
  std::fill(chosen_.begin(), chosen_.end(), 0);
  for (const std::uint32_t k : found.nodes) chosen_[k] = 1;
  chosen_[n] = 1;
  chosen_count_ = found.nodes.size() + 1;
}

std::pair<std::uint32_t, std::uint32_t> LoopConsistency::joins(std::size_t loop) const {
  const Factor& factor = loops_[loop].factor;
  return std::minmax(nodes_[factor.i].stretch, nodes_[factor.j].stretch);
}

void LoopConsistency::believeChosen() {
  believed_ = chosen_;
  if (nodes_.empty() || nodes_.back().stretch == 0) return;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> loops_across;
  for (std::size_t k = 0; k < loops_.size(); ++k)
    if (chosen_[k] != 0) ++loops_across[joins(k)];
  for (std::size_t k = 0; k < loops_.size(); ++k)
    if (const auto across = joins(k); across.first != across.second && loops_across[across] < params_.min_across)
      believed_[k] = 0;
}

}  // namespace scslam
