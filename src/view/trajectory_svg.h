// One page: the trajectory before and after loop closing, from above and from the side.
#pragma once
#include <string>

#include "scslam/apps/evaluate.h"
#include "scslam/session/session.h"

namespace scslam {

struct TrajectorySvgOptions {
  std::string title;                       ///< empty: the folder's name
  const Evaluation* evaluation = nullptr;  ///< of this session: adds the ground truth and the ATE
};

/// An SVG of 900 x 700: from above (equal axes, scale bar) odometry grey, optimised blue, ground truth dashed,
/// accepted loops green, refused candidates as faint red dots; below it the height over the way driven, where drift
/// shows first.
std::string trajectorySvg(const Session& session, const TrajectorySvgOptions& options = {});

}  // namespace scslam
