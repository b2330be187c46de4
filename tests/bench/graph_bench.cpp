// Pose-graph optimisation against plain Ceres on the same machine, in the same run:
//   graph_bench GRAPH.g2o …
// Ours = start (the better of file, spanning tree, chordal) + optimisation. Plain Ceres = automatic derivatives,
// SPARSE_NORMAL_CHOLESKY with SuiteSparse, Levenberg-Marquardt with default trust region, one thread, from the file's
// own poses (from the spanning tree where the file has none). Both measure the same residual; best of several runs.
#include <ceres/ceres.h>
#include <fmt/format.h>

#include <chrono>

#include "scslam/core/error.h"
#include "scslam/graph/factor_error.h"
#include "scslam/graph/g2o.h"
#include "scslam/graph/optimiser.h"

namespace scslam {
namespace {

struct AutoDiffError {
  Eigen::Vector3d t;
  Eigen::Quaterniond q;
  Matrix6d whitening;

  template <class T>
  bool operator()(const T* t_i, const T* q_i, const T* t_j, const T* q_j, T* residuals) const {
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    using Quaternion = Eigen::Quaternion<T>;
    const Eigen::Map<const Vector3> a(t_i), b(t_j);
    const Eigen::Map<const Quaternion> p(q_i), r(q_j);
    const Quaternion z_inverse = q.conjugate().cast<T>();
    Quaternion e = z_inverse * (p.conjugate() * r);
    if (e.w() < T(0)) e.coeffs() = -e.coeffs();
    Eigen::Matrix<T, 6, 1> error;
    error.template head<3>() = z_inverse * (p.conjugate() * (b - a) - t.cast<T>());
    const T angle_axis_scale =
        e.vec().squaredNorm() > T(1e-18) ? T(2) * ceres::atan2(e.vec().norm(), e.w()) / e.vec().norm() : T(2);
    error.template tail<3>() = angle_axis_scale * e.vec();
    Eigen::Map<Eigen::Matrix<T, 6, 1>> out(residuals);
    out = whitening.cast<T>() * error;
    return true;
  }
};

double plainCeres(PoseGraph& graph) {
  std::vector<Eigen::Vector3d> t;
  std::vector<Eigen::Quaterniond> q;
  for (const Pose& pose : graph.poses) t.push_back(pose.translation()), q.emplace_back(pose.linear());
  ceres::Problem problem;
  for (std::size_t v = 0; v < t.size(); ++v) {
    problem.AddParameterBlock(t[v].data(), 3);
    problem.AddParameterBlock(q[v].coeffs().data(), 4, new ceres::EigenQuaternionManifold);
  }
  for (const Factor& f : graph.factors) {
    Matrix6d information = f.information;
    if (graph.planar)  // the axes an SE(2) graph does not measure stay where they are
      for (const int axis : {2, 3, 4})
        information.row(axis).setZero(), information.col(axis).setZero(), information(axis, axis) = 1;
    const Matrix6d whitening = information.llt().matrixU();
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<AutoDiffError, 6, 3, 4, 3, 4>(new AutoDiffError{
                                 f.T_i_j.translation(), Eigen::Quaterniond(f.T_i_j.linear()), whitening}),
                             nullptr, t[f.i].data(), q[f.i].coeffs().data(), t[f.j].data(), q[f.j].coeffs().data());
  }
  problem.SetParameterBlockConstant(t[0].data());
  problem.SetParameterBlockConstant(q[0].coeffs().data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  options.max_num_iterations = 200;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  for (std::size_t v = 0; v < t.size(); ++v) {
    graph.poses[v].translation() = t[v];
    graph.poses[v].linear() = q[v].normalized().toRotationMatrix();
  }
  return graphChi2(graph);
}

struct Timed {
  double best_ms = 1e300, chi2 = 0;
};

template <class Solve>
Timed timed(const PoseGraph& graph, int runs, Solve solve) {
  Timed result;
  for (int k = 0; k < runs; ++k) {
    PoseGraph copy = graph;
    const auto begin = std::chrono::steady_clock::now();
    result.chi2 = solve(copy);
    const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - begin;
    result.best_ms = std::min(result.best_ms, elapsed.count());
  }
  return result;
}

void compare(const std::string& name) {
  G2oFile file = readG2o(name);
  if (!file.poses_known) placeAlongSpanningTree(file.graph);
  OptimiserSummary summary;
  const auto ours = timed(file.graph, 5, [&](PoseGraph& graph) {
    summary = optimise(graph);
    return summary.chi2_final;
  });
  OptimiserParams with_ceres;
  with_ceres.solver = "ceres";
  const auto tuned = timed(file.graph, 3, [&](PoseGraph& graph) { return optimise(graph, with_ceres).chi2_final; });
  const auto plain = timed(file.graph, 3, [](PoseGraph& graph) { return plainCeres(graph); });
  const std::string base = std::filesystem::path(name).filename().string();
  fmt::print(
      "{:<30} ours {:8.1f} ms chi2 {:<12.8g} ({} from {}, {} it)  Ceres from our start {:8.1f} ms chi2 {:<12.8g}  "
      "plain Ceres {:8.1f} ms chi2 {:<12.8g}  ratio {:.3f}\n",
      base, ours.best_ms, ours.chi2, summary.converged ? "converged" : "stopped", summary.start, summary.iterations,
      tuned.best_ms, tuned.chi2, plain.best_ms, plain.chi2, ours.best_ms / plain.best_ms);
}

}  // namespace
}  // namespace scslam

int main(int argc, char** argv) {
  try {
    for (int k = 1; k < argc; ++k) scslam::compare(argv[k]);
  } catch (const scslam::Error& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return static_cast<int>(error.code());
  }
  return 0;
}
