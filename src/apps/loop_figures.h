#pragma once
#include <optional>
#include <vector>

#include "scslam/apps/evaluate.h"

namespace scslam {

/// Precision over the accepted loops, recall over the keyframes that revisit an earlier place.
/// @param T_truth_keyframe per keyframe, where there is truth.
LoopFigures loopFigures(const std::vector<LoopRecord>& loops, const std::vector<std::optional<Pose>>& T_truth_keyframe,
                        const EvaluationOptions& options);

}  // namespace scslam
