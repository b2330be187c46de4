#include "scslam/graph/ceres_solver.h"

#include <ceres/ceres.h>

#include <Eigen/Eigenvalues>

#include "scslam/graph/factor_error.h"

namespace scslam::detail {
namespace {

using Block = Eigen::Matrix<double, 7, 1>;  // translation, quaternion (x y z w)

Pose poseOf(const double* x) {
  Pose T = Pose::Identity();
  T.linear() = Eigen::Map<const Eigen::Quaterniond>(x + 3).normalized().toRotationMatrix();
  T.translation() = Eigen::Map<const Eigen::Vector3d>(x);
  return T;
}

Block blockOf(const Pose& T) {
  Block x;
  x << T.translation(), Eigen::Quaterniond(T.linear()).normalized().coeffs();
  return x;
}

/// q (1, v/2) = q + dq/dv v: the derivative of a small right rotation.
Eigen::Matrix<double, 4, 3> quaternionDerivative(const double* q) {
  Eigen::Matrix<double, 4, 3> D;
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  D << w, -z, y, z, w, -x, -y, x, w, -x, -y, -z;
  return D / 2;
}

/// x (+) delta = retract(x, delta); with Dof = 3 only (x, y, yaw) move.
template <int Dof>
class PoseManifold : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return Dof; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    Vector6d full = Vector6d::Zero();
    for (int k = 0; k < Dof; ++k) full(axis(k)) = delta[k];
    Eigen::Map<Block> moved(x_plus_delta);
    moved = blockOf(retract(poseOf(x), full));
    return true;
  }
  bool PlusJacobian(const double* x, double* jacobian) const override {
    const auto full = plusJacobian(x);
    Eigen::Map<Eigen::Matrix<double, 7, Dof, Eigen::RowMajor>> J(jacobian);
    for (int k = 0; k < Dof; ++k) J.col(k) = full.col(axis(k));
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    const Vector6d full = local(poseOf(x), poseOf(y));
    for (int k = 0; k < Dof; ++k) y_minus_x[k] = full(axis(k));
    return true;
  }
  bool MinusJacobian(const double* x, double* jacobian) const override {
    const auto full = minusJacobian(x);
    Eigen::Map<Eigen::Matrix<double, Dof, 7, Eigen::RowMajor>> J(jacobian);
    for (int k = 0; k < Dof; ++k) J.row(k) = full.row(axis(k));
    return true;
  }

  static int axis(int k) { return Dof == 6 ? k : kPlanarAxes[k % 3]; }
  static Eigen::Matrix<double, 7, 6> plusJacobian(const double* x) {
    Eigen::Matrix<double, 7, 6> J = Eigen::Matrix<double, 7, 6>::Zero();
    J.topLeftCorner<3, 3>() = poseOf(x).linear();
    J.bottomRightCorner<4, 3>() = quaternionDerivative(x + 3);
    return J;
  }
  static Eigen::Matrix<double, 6, 7> minusJacobian(const double* x) {
    Eigen::Matrix<double, 6, 7> J = Eigen::Matrix<double, 6, 7>::Zero();
    J.topLeftCorner<3, 3>() = poseOf(x).linear().transpose();
    J.bottomRightCorner<3, 4>() = 4 * quaternionDerivative(x + 3).transpose();
    return J;
  }
};

/// A with A^T A = information: for Lambda = L L^T that is L^T, here through the eigenvectors so that a singular
/// information is allowed.
template <int Dof>
Eigen::Matrix<double, Dof, Dof> whitening(const Matrix6d& information) {
  Eigen::Matrix<double, Dof, Dof> selected;
  for (int r = 0; r < Dof; ++r)
    for (int c = 0; c < Dof; ++c) selected(r, c) = information(PoseManifold<Dof>::axis(r), PoseManifold<Dof>::axis(c));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, Dof, Dof>> eigen(selected);
  return eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose();
}

template <int Dof>
class FactorCost : public ceres::CostFunction {
 public:
  FactorCost(const Factor& factor, double weight)
      : factor_(factor), whitening_(std::sqrt(weight) * whitening<Dof>(factor.information)) {
    set_num_residuals(Dof);
    mutable_parameter_block_sizes()->push_back(7);
    if (!isUnary(factor.kind)) mutable_parameter_block_sizes()->push_back(7);
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const bool prior = isUnary(factor_.kind);
    const double* x_j = prior ? x[0] : x[1];
    Matrix6d J_i, J_j;
    const Vector6d r = factorError(factor_, poseOf(x[0]), poseOf(x_j), J_i, J_j);
    Eigen::Map<Eigen::Matrix<double, Dof, 1>>(residuals, Dof) = whitening_ * rowsOf(r);
    if (jacobians == nullptr) return true;
    if (!prior && jacobians[0] != nullptr) ambient(J_i, x[0], jacobians[0]);
    if (double* last = jacobians[prior ? 0 : 1]; last != nullptr) ambient(J_j, x_j, last);
    return true;
  }

 private:
  template <class Derived>
  static Eigen::Matrix<double, Dof, Derived::ColsAtCompileTime> rowsOf(const Eigen::MatrixBase<Derived>& full) {
    Eigen::Matrix<double, Dof, Derived::ColsAtCompileTime> selected;
    for (int k = 0; k < Dof; ++k) selected.row(k) = full.row(PoseManifold<Dof>::axis(k));
    return selected;
  }
  /// Ceres multiplies by the manifold's plus-Jacobian, which our minus-Jacobian undoes.
  void ambient(const Matrix6d& J, const double* x, double* out) const {
    Eigen::Map<Eigen::Matrix<double, Dof, 7, Eigen::RowMajor>> target(out);
    target = whitening_ * rowsOf(J * PoseManifold<Dof>::minusJacobian(x));
  }
  Factor factor_;
  Eigen::Matrix<double, Dof, Dof> whitening_;
};

class KernelLoss : public ceres::LossFunction {
 public:
  explicit KernelLoss(const RobustKernel& kernel) : kernel_(kernel) {}
  void Evaluate(double s, double* out) const override {
    const auto value = kernel_(s);
    out[0] = value.rho;
    out[1] = value.weight;
    out[2] = 0;  // no second-order correction: reweighted least squares, positive definite for every kernel
  }

 private:
  RobustKernel kernel_;
};

template <int Dof>
MinimiseResult run(PoseGraph& graph, const GraphStructure& structure, const Weighting& weighting,
                   const MinimiseOptions& options) {
  std::vector<Block> blocks;
  blocks.reserve(graph.poses.size());
  for (const Pose& pose : graph.poses) blocks.push_back(blockOf(pose));
  PoseManifold<Dof> manifold;
  KernelLoss loss(weighting.kernel);
  ceres::Problem::Options problem_options;
  problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.enable_fast_removal = false;
  ceres::Problem problem(problem_options);
  for (std::size_t v = 0; v < blocks.size(); ++v) {
    problem.AddParameterBlock(blocks[v].data(), 7, &manifold);
    if (structure.variable[v] == GraphStructure::kHeld) problem.SetParameterBlockConstant(blocks[v].data());
  }
  for (std::size_t f = 0; f < graph.factors.size(); ++f) {
    const Factor& factor = graph.factors[f];
    if (!weighting.weights.empty() && weighting.weights[f] == 0) continue;
    auto* cost = new FactorCost<Dof>(factor, weighting.weights.empty() ? 1 : weighting.weights[f]);
    const bool robust = isRobust(factor.kind) && weighting.kernel.kind() != KernelKind::kNone;
    std::vector<double*> of{blocks[factor.i].data()};
    if (!isUnary(factor.kind)) of.push_back(blocks[factor.j].data());
    problem.AddResidualBlock(cost, robust ? &loss : nullptr, of);
  }
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.max_num_iterations = options.max_iterations;
  solver.initial_trust_region_radius = 1e16;  // the start is good: Gauss-Newton until a step fails
  solver.max_trust_region_radius = 1e20;
  solver.function_tolerance = options.relative_decrease;
  solver.gradient_tolerance = 0;
  solver.parameter_tolerance = 1e-14;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  for (std::size_t v = 0; v < blocks.size(); ++v)
    if (structure.variable[v] != GraphStructure::kHeld) graph.poses[v] = poseOf(blocks[v].data());
  return {static_cast<int>(summary.iterations.size()) - 1, summary.termination_type == ceres::CONVERGENCE,
          weighting.cost(graph)};
}

}  // namespace

MinimiseResult minimiseWithCeres(PoseGraph& graph, const GraphStructure& structure, const Weighting& weighting,
                                 const MinimiseOptions& options) {
  if (structure.variables == 0) return {0, true, weighting.cost(graph)};
  return graph.planar ? run<3>(graph, structure, weighting, options) : run<6>(graph, structure, weighting, options);
}

}  // namespace scslam::detail
