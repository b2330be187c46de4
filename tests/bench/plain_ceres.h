// What most programs do with a pose graph, to compare with: Ceres, automatic derivatives, SPARSE_NORMAL_CHOLESKY with
// SuiteSparse, Levenberg-Marquardt with the default trust region, one thread. The residual is that of factor_error.h.
#pragma once
#include <ceres/ceres.h>

#include "scslam/graph/factor_error.h"

namespace scslam::bench {

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

/// From graph.poses to where it ends. @return the cost there
inline double plainCeres(PoseGraph& graph) {
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

}  // namespace scslam::bench
