// One page: the trajectory before and after loop closing, from above and from the side.
#pragma once
#include <optional>
#include <string>

#include "scslam/session/session.h"

namespace scslam {

/// An SVG of 900 x 700: from above (equal axes, scale bar) odometry grey, optimised blue, ground truth dashed,
/// accepted loops green, refused candidates as faint red dots; below it the height over the way driven, where drift
/// shows first.
/// @param truth T_map_base in a frame of its own; laid on the optimised trajectory, which adds the ATE to the title.
/// One that does not belong to the session (no common time) is left out.
std::string trajectorySvg(const Session& session, const std::optional<Trajectory>& truth = std::nullopt);

}  // namespace scslam
