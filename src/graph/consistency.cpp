#include "scslam/graph/consistency.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "scslam/graph/factor_error.h"

namespace scslam {
namespace {

Matrix6d symmetric(const Matrix6d& M) { return 0.5 * (M + M.transpose()); }

/// What a loop's information leaves open counts as this much [m^2, rad^2]: beyond any cycle's error.
constexpr double kOpen = 1e6;

Matrix6d covarianceOf(const Matrix6d& information) {
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(symmetric(information));
  const Vector6d variances = eigen.eigenvalues().unaryExpr([](double v) { return v > 1 / kOpen ? 1 / v : kOpen; });
  return eigen.eigenvectors() * variances.asDiagonal() * eigen.eigenvectors().transpose();
}

Matrix6d diagonal(double level_m, double up_m, double turn_rad) {
  Vector6d v;
  v << level_m * level_m, level_m * level_m, up_m * up_m, Eigen::Vector3d::Constant(turn_rad * turn_rad);
  return v.asDiagonal();
}

/// Covariance of T^-1, given that of T (in the frame T leads to); the frame T comes from.
Matrix6d inverted(const Matrix6d& covariance, const Pose& T) {
  const Matrix6d A = adjoint(T);
  return symmetric(A * covariance * A.transpose());
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
  v.field("budget", budget, "branches of the search for the largest set at most, per loop", 1, 1000000000);
}

void LoopConsistency::addNode(const Pose& T_odom_base, double travelled_m, const Matrix6d& step_covariance,
                              bool planar) {
  planar_ = planar;
  Matrix6d covariance = Matrix6d::Zero();
  if (!nodes_.empty())
    covariance = symmetric(composeCovariance(nodes_.back().covariance,
                                             nodes_.back().T_odom_base.inverse() * T_odom_base, step_covariance));
  nodes_.push_back({T_odom_base, travelled_m, covariance});
}

/// Of T_from_to along the odometry, frame `to`: what the way to `to` adds to the way to `from`.
Matrix6d LoopConsistency::pathCovariance(std::uint32_t from, std::uint32_t to) const {
  const bool forward = from <= to;
  const Node& a = nodes_[forward ? from : to];
  const Node& b = nodes_[forward ? to : from];
  const Pose T_a_b = a.T_odom_base.inverse() * b.T_odom_base;
  const Matrix6d A = adjoint(Pose(T_a_b.inverse()));
  const double way = b.travelled_m - a.travelled_m;
  Matrix6d covariance = symmetric(b.covariance - A * a.covariance * A.transpose());
  covariance += diagonal(params_.odometry_sigma_per_m * way, params_.odometry_sigma_up_per_m * way,
                         params_.odometry_sigma_deg_per_m * M_PI / 180 * way);
  return forward ? covariance : inverted(covariance, T_a_b);
}

/// T_i_k (loop a), odometry k to l, T_l_j (loop b backwards), odometry j to i.
double LoopConsistency::disagreement(std::size_t a, std::size_t b) const {
  const Factor &one = loops_[a].factor, &two = loops_[b].factor;
  const Pose T_k_l = nodes_[one.j].T_odom_base.inverse() * nodes_[two.j].T_odom_base;
  const Pose T_j_i = nodes_[two.i].T_odom_base.inverse() * nodes_[one.i].T_odom_base;
  const Pose T_l_j = two.T_i_j.inverse();
  Matrix6d covariance = composeCovariance(loops_[a].covariance, T_k_l, pathCovariance(one.j, two.j));
  covariance = composeCovariance(covariance, T_l_j, inverted(loops_[b].covariance, two.T_i_j));
  covariance = symmetric(composeCovariance(covariance, T_j_i, pathCovariance(two.i, one.i)));
  const Vector6d error = local(Pose::Identity(), one.T_i_j * T_k_l * T_l_j * T_j_i);
  if (!planar_) return error.dot(covariance.ldlt().solve(error));
  Eigen::Vector3d e;
  Eigen::Matrix3d C;
  for (int r = 0; r < 3; ++r) {
    e(r) = error(kPlanarAxes[r]);
    for (int c = 0; c < 3; ++c) C(r, c) = covariance(kPlanarAxes[r], kPlanarAxes[c]);
  }
  return e.dot(C.ldlt().solve(e));
}

std::size_t LoopConsistency::addLoop(const Factor& loop) {
  const double turn = params_.loop_sigma_deg * M_PI / 180;
  loops_.push_back({loop, covarianceOf(loop.information) + diagonal(params_.loop_sigma_m, params_.loop_sigma_m, turn)});
  const std::size_t n = loops_.size() - 1;
  std::vector<std::uint32_t> agreeing;
  std::size_t with_believed = 0;
  for (std::uint32_t other = 0; other < n; ++other) {
    if (!(disagreement(other, n) <= params_.gate_chi2)) continue;
    agreeing.push_back(other);
    with_believed += believed_[other];
  }
  agree_.add(agreeing);
  believed_.push_back(0);
  if (with_believed == believed_count_) {  // one more than the largest so far cannot be beaten
    believed_[n] = 1;
    ++believed_count_;
    return n;
  }
  // A larger set than the believed one must contain the new loop, and otherwise only what agrees with it.
  const CliqueResult found = maxClique(agree_, agreeing, believed_count_ - 1, static_cast<std::size_t>(params_.budget));
  if (found.nodes.empty()) return n;
  std::fill(believed_.begin(), believed_.end(), 0);
  for (const std::uint32_t k : found.nodes) believed_[k] = 1;
  believed_[n] = 1;
  believed_count_ = found.nodes.size() + 1;
  return n;
}

}  // namespace scslam
