#include "scslam/graph/block_cholesky.h"
#include "scslam/graph/initial_guess.h"

namespace scslam::detail {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// sum over factors of ||A_j x_j - A_i x_i - b||^2_W as normal equations with 3x3 blocks and one or more right-hand
/// sides.
struct LinearGraph {
  const GraphStructure& structure;
  std::vector<double> blocks;
  std::vector<std::vector<double>> rhs;

  LinearGraph(const GraphStructure& s, std::size_t sides)
      : structure(s),
        blocks((s.variables + s.pairs.size()) * 9),
        rhs(sides, std::vector<double>(std::size_t{s.variables} * 3)) {}
  Eigen::Map<Matrix3d> block(std::uint32_t number) {
    return Eigen::Map<Matrix3d>(blocks.data() + std::size_t{number} * 9);
  }
  void addDiagonal(std::uint32_t v, const Matrix3d& H) {
    if (v != GraphStructure::kHeld) block(v) += H;
  }
  /// H_ij with rows of node i.
  void addOff(std::size_t factor, std::uint32_t vi, std::uint32_t vj, const Matrix3d& H) {
    if (structure.block[factor] == GraphStructure::kHeld) return;
    block(structure.block[factor]) += vi < vj ? H : Matrix3d(H.transpose());
  }
  void addRhs(std::size_t side, std::uint32_t v, const Vector3d& value) {
    if (v != GraphStructure::kHeld) Eigen::Map<Vector3d>(rhs[side].data() + std::size_t{v} * 3) += value;
  }
  bool solve() {
    BlockCholesky<3> cholesky(structure.symbolic);
    if (!cholesky.factor(blocks, 0)) return false;
    for (auto& side : rhs) cholesky.solve(side);
    return true;
  }
};

/// Positions and gravity are not linear in rotations and translations alone: they come in with the first full step.
bool counts(const Factor& factor) { return isRelative(factor.kind) || factor.kind == FactorKind::kPrior; }

double weightOf(const std::vector<double>& weights, std::size_t f) { return weights.empty() ? 1 : weights[f]; }

/// R_j = R_i Z: with the rows of R as column vectors a, a_j = Z^T a_i; the three rows share the matrix.
bool relaxedRotations(const PoseGraph& graph, const GraphStructure& structure, const std::vector<double>& weights,
                      std::vector<Matrix3d>& rotations) {
  LinearGraph system(structure, 3);
  for (std::size_t f = 0; f < graph.factors.size(); ++f) {
    const Factor& factor = graph.factors[f];
    if (!counts(factor) || weightOf(weights, f) == 0) continue;
    const std::uint32_t vi = structure.variable[factor.i], vj = structure.variable[factor.j];
    const Matrix3d Z_t = factor.T_i_j.linear().transpose();
    const double w = weightOf(weights, f) * (graph.planar ? factor.information(5, 5)
                                                          : factor.information.bottomRightCorner<3, 3>().trace() / 3);
    system.addDiagonal(vj, w * Matrix3d::Identity());
    const bool prior = factor.kind == FactorKind::kPrior;
    if (!prior) {
      system.addDiagonal(vi, w * Matrix3d::Identity());
      system.addOff(f, vi, vj, -w * Z_t.transpose());
    }
    for (int side = 0; side < 3; ++side) {
      const std::size_t k = static_cast<std::size_t>(side);
      if (prior) system.addRhs(k, vj, w * Z_t.col(side));
      if (!prior && vi == GraphStructure::kHeld)
        system.addRhs(k, vj, w * (Z_t * graph.poses[factor.i].linear().row(side).transpose()));
      if (!prior && vj == GraphStructure::kHeld)
        system.addRhs(k, vi, w * (Z_t.transpose() * graph.poses[factor.j].linear().row(side).transpose()));
    }
  }
  if (!system.solve()) return false;
  for (std::size_t v = 0; v < rotations.size(); ++v) {
    if (structure.variable[v] == GraphStructure::kHeld) continue;
    const std::size_t at = std::size_t{structure.variable[v]} * 3;
    Pose relaxed = Pose::Identity();
    for (std::size_t side = 0; side < 3; ++side)
      for (std::size_t k = 0; k < 3; ++k)
        relaxed.linear()(static_cast<int>(side), static_cast<int>(k)) = system.rhs[side][at + k];
    rotations[v] = orthonormalised(relaxed).linear();
  }
  return true;
}

/// t_j - t_i = R_i t_z, weighted by the factor's information turned into the map frame.
bool translations(PoseGraph& graph, const GraphStructure& structure, const std::vector<double>& weights) {
  LinearGraph system(structure, 1);
  for (std::size_t f = 0; f < graph.factors.size(); ++f) {
    const Factor& factor = graph.factors[f];
    if (!counts(factor) || weightOf(weights, f) == 0) continue;
    const std::uint32_t vi = structure.variable[factor.i], vj = structure.variable[factor.j];
    const bool prior = factor.kind == FactorKind::kPrior;
    const Matrix3d R_i = prior ? Matrix3d::Identity() : Matrix3d(graph.poses[factor.i].linear());
    const Matrix3d R = R_i * factor.T_i_j.linear();
    Matrix3d W = weightOf(weights, f) * (R * factor.information.topLeftCorner<3, 3>() * R.transpose());
    if (graph.planar) {  // z is no variable of a planar graph; 1 keeps the system regular and z where the anchor has it
      W.row(2).setZero();
      W.col(2).setZero();
      W(2, 2) = 1;
    }
    Vector3d b = R_i * factor.T_i_j.translation();
    system.addDiagonal(vj, W);
    if (!prior) {
      system.addDiagonal(vi, W);
      system.addOff(f, vi, vj, -W);
      if (vi == GraphStructure::kHeld) b += graph.poses[factor.i].translation();
      if (vj == GraphStructure::kHeld) b -= graph.poses[factor.j].translation();
      system.addRhs(0, vi, -W * b);
    }
    system.addRhs(0, vj, W * b);
  }
  if (!system.solve()) return false;
  for (std::size_t v = 0; v < graph.poses.size(); ++v)
    if (structure.variable[v] != GraphStructure::kHeld)
      graph.poses[v].translation() =
          Eigen::Map<const Vector3d>(system.rhs[0].data() + std::size_t{structure.variable[v]} * 3);
  return true;
}

}  // namespace

bool chordal(PoseGraph& graph, const GraphStructure& structure, const std::vector<double>& weights) {
  std::vector<Matrix3d> rotations;
  rotations.reserve(graph.poses.size());
  for (const Pose& pose : graph.poses) rotations.push_back(pose.linear());
  if (!relaxedRotations(graph, structure, weights, rotations)) return false;
  const std::vector<Pose> before = graph.poses;
  for (std::size_t v = 0; v < rotations.size(); ++v) graph.poses[v].linear() = rotations[v];
  if (translations(graph, structure, weights)) return true;
  graph.poses = before;
  return false;
}

}  // namespace scslam::detail
