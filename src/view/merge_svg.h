// A merged session from above, each parent in its own colour.
#pragma once
#include <string>

#include "scslam/apps/merge/merge.h"
#include "scslam/session/session.h"

namespace scslam {

/// An SVG, 900 x 700: the keyframes of each parent as a line, loops between two parents green, those within one grey.
std::string mergeSvg(const Session& merged, const MergeSummary& summary);

}  // namespace scslam
