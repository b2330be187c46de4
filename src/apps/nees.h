// Is a covariance honest? Normalised estimation error squared of odometry steps.
#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "scslam/apps/evaluate.h"
#include "scslam/session/session.h"

namespace scslam {

/// Bar-Shalom, Li and Kirubarajan, "Estimation with Applications to Tracking and Navigation", Sec. 5.4: for a
/// covariance that tells the truth, e^T P^-1 e has the mean `dimensions`, and the mean of n of them lies in [low, high]
/// with 95 %. Above: over-confident. Below: pessimistic.
struct StepConsistency {
  int dimensions = 6;               ///< 3 (x, y, yaw) for planar data
  std::size_t steps = 0;            ///< between consecutive keyframes that both have truth
  std::size_t singular = 0;         ///< of those, with a covariance that is not positive definite; not in the mean
  std::optional<double> mean;       ///< absent without steps
  double low = 0, high = 0;         ///< 95 % band of the mean, of chi-square / n
  std::optional<double> inside_95;  ///< share of the steps within their own 95 % bound
  /// Per axis (x y z, rotation vector) the rms of error / standard deviation: 1 is honest. 0 for axes that do not
  /// count.
  std::array<double, 6> axis_ratio{};
};
/// @param T_truth_base per keyframe, where there is truth.
StepConsistency stepConsistency(const std::vector<Keyframe>& keyframes,
                                const std::vector<std::optional<Pose>>& T_truth_base, bool planar);
/// @param evaluation of the session.
StepConsistency stepConsistency(const Session& session, const Evaluation& evaluation);

/// Quantile of the chi-square distribution for a normal quantile z (1.96: 97.5 %), by Wilson and Hilferty's cube;
/// within 1 % from three degrees of freedom on.
double chiSquareQuantile(double degrees_of_freedom, double z);

}  // namespace scslam
