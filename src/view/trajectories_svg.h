// The trajectories of a comparison, a panel per input.
#pragma once
#include <string>
#include <vector>

#include "scslam/apps/compare.h"

namespace scslam {

/// An SVG, 900 px wide, panels in two columns, from above with equal axes: truth dashed black, each front-end in its
/// own colour, odometry thin and pale, with loops full. With truth everything is laid on it; without, as it came. Runs
/// without a session have no line.
std::string trajectoriesSvg(const std::vector<ComparedRun>& runs);

}  // namespace scslam
