#include "scslam/apps/nees.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace scslam {
namespace {

/// e^T P^-1 e over the axes that count; nullopt when P is not positive definite there.
std::optional<double> normalisedSquare(const Vector6d& error, const Matrix6d& covariance,
                                       const std::vector<int>& axes) {
  const auto n = static_cast<Eigen::Index>(axes.size());
  Eigen::VectorXd e(n);
  Eigen::MatrixXd P(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    e(i) = error(axes[static_cast<std::size_t>(i)]);
    for (Eigen::Index j = 0; j < n; ++j)
      P(i, j) = covariance(axes[static_cast<std::size_t>(i)], axes[static_cast<std::size_t>(j)]);
  }
  const Eigen::LLT<Eigen::MatrixXd> llt(P);
  if (!P.allFinite() || llt.info() != Eigen::Success) return std::nullopt;
  const double square = e.dot(llt.solve(e));
  return std::isfinite(square) ? std::optional(square) : std::nullopt;
}

std::vector<std::optional<Pose>> truthOfKeyframes(const Session& session, const Evaluation& evaluation) {
  std::vector<std::optional<Pose>> truth(session.keyframes().size());
  for (std::size_t i = 0; i < session.scans().size(); ++i) {
    const std::int64_t k = session.scans()[i].keyframe;
    if (k < 0 || static_cast<std::size_t>(k) >= truth.size()) continue;
    const auto at = static_cast<std::size_t>(k);
    if (session.keyframes()[at].scan_index == session.scans()[i].index) truth[at] = evaluation.T_truth_base[i];
  }
  return truth;
}

}  // namespace

double chiSquareQuantile(double degrees_of_freedom, double z) {
  const double v = 2 / (9 * degrees_of_freedom);
  return degrees_of_freedom * std::pow(1 - v + z * std::sqrt(v), 3);
}

StepConsistency stepConsistency(const std::vector<Keyframe>& keyframes,
                                const std::vector<std::optional<Pose>>& T_truth_base, bool planar) {
  StepConsistency result;
  const std::vector<int> axes = planar ? std::vector<int>{0, 1, 5} : std::vector<int>{0, 1, 2, 3, 4, 5};
  result.dimensions = static_cast<int>(axes.size());
  const double bound = chiSquareQuantile(result.dimensions, 1.6448536269514722);
  double sum = 0;
  std::array<double, 6> ratio{};
  std::size_t inside = 0, counted = 0;
  for (std::size_t k = 1; k < keyframes.size(); ++k) {
    if (!T_truth_base[k - 1] || !T_truth_base[k]) continue;
    ++result.steps;
    const Vector6d error = local(T_truth_base[k - 1]->inverse() * *T_truth_base[k],
                                 keyframes[k - 1].T_odom_base.inverse() * keyframes[k].T_odom_base);
    Matrix6d covariance = keyframes[k].step_covariance;
    covariance.diagonal() += keyframes[k].step_passing;
    const auto square = normalisedSquare(error, covariance, axes);
    if (!square) {
      ++result.singular;
      continue;
    }
    ++counted;
    sum += *square;
    for (const int axis : axes)
      ratio[static_cast<std::size_t>(axis)] += error(axis) * error(axis) / covariance(axis, axis);
    inside += *square <= bound;
  }
  if (counted == 0) return result;
  const double n = static_cast<double>(counted);
  result.mean = sum / n;
  for (std::size_t axis = 0; axis < 6; ++axis) result.axis_ratio[axis] = std::sqrt(ratio[axis] / n);
  result.inside_95 = static_cast<double>(inside) / n;
  result.low = chiSquareQuantile(result.dimensions * n, -1.959963984540054) / n;
  result.high = chiSquareQuantile(result.dimensions * n, 1.959963984540054) / n;
  return result;
}

StepConsistency stepConsistency(const Session& session, const Evaluation& evaluation) {
  return stepConsistency(session.keyframes(), truthOfKeyframes(session, evaluation), session.info().planar);
}

}  // namespace scslam
