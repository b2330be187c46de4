// Which loops do their neighbours speak for? A loop that joins two stretches of the drive is supported by another loop
// between the same stretches when the short cycle of both closes: the odometry between neighbours is good even where
// the drift between the stretches is beyond any gate. Random false loops have no neighbours that agree with them, so
// this sorts out most of them before anything is solved.
#pragma once
#include <cstdint>
#include <vector>

#include "scslam/graph/odometry_chain.h"

namespace scslam {

struct LoopSupport {
  /// By factor: more neighbours agree than contradict, and one at least. 0 for other kinds than loops.
  std::vector<std::uint8_t> trusted;
  /// Variance factor of the cycles that close: about 1 for honest information matrices, 0.01 where they claim ten times
  /// the errors there are. Not above 1.
  double variance_factor = 1;
};

/// Information matrices are rarely right on every axis and errors have long tails: what exceeds so many times the
/// variance factor (4 sigma) is no error of the usual kind, even where the nominal gate is wider.
inline constexpr double kVarianceMargin = 16;

/// Neighbours are loops whose ends are at most 10 odometry steps away from this one's, and together not more than a
/// quarter of the steps between its own ends (else the cycle says little more than the loop's own). The first few in
/// order of their ends are asked.
LoopSupport loopSupport(const PoseGraph& graph, const OdometryChain& chain);

/// 90 % quantile of the chi-square distribution for 6 and 3 degrees of freedom.
double ninetyPercent(bool planar);
/// The value that one in ten exceeds; `values` is not empty.
double upperDecile(std::vector<double> values);

}  // namespace scslam
