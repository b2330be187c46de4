// Six scores between 0 and 1: how near the figures of some scans are to those of real ones.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "sim/realism_target.h"

namespace scslam::sim {

struct Score {
  std::string name;
  std::optional<double> value;  ///< absent: could not be judged, `note` says why
  double goal = 0;              ///< what a simulation that is good enough reaches
  std::string note;             ///< what decided it, what was left out
};

/// A figure measured on one side only counts neither for nor against.
///  grid             1 when the elevations and the time a column are those of `table`, the azimuths lie on one fixed
///  grid
///                   a ring and the ranges on the target's quantum, each within target.grid; 0 when one of them is not
///  noise            1 - max over bins |ln(sigma / target)| / ln 2
///  drop-out         1 - mean over bins of range and of signal |ln(rate / target)| / ln 10; a bin off by more than ten
///                   times counts as ten times
///  ring occupancy   1 - RMS difference of the return rate per ring over pixels ever seen; from five scans on
///  range histogram  1 - Jensen-Shannon divergence (base 2) from the nearest of the target and `real_sets`
///  local geometry   1 - half the L1 distance of linear/planar/scatter, or of jump and mixed-pixel rate: the larger one
/// @param table the sensor table that `figures` were measured with.
/// @param real_sets other real sets; the scene of the scans need not be that of the sensor's target.
std::vector<Score> scoreRealism(const RealismFigures& figures, const SensorModel& table, const RealismTarget& target,
                                const std::vector<RealismTarget>& real_sets = {});

}  // namespace scslam::sim
