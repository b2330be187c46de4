// Localised scans against the truth.
#pragma once
#include <filesystem>
#include <vector>

#include "scslam/apps/localize/localize.h"

namespace scslam {

struct TrackedScan {
  Stamp stamp;
  std::size_t index = 0;  ///< in the input
  Pose T_map_base = Pose::Identity();
  KeyframeId keyframe = 0;  ///< of the map, against whose surroundings it was registered
};

/// @param truth of the input, T_world_base: timed, or one row per scan of the input. @param session_truth likewise of
/// the session; empty: none. @throw inputError where they have nothing in common with what was localised.
LocalizeError localizeError(const std::vector<TrackedScan>& scans, const SavedMap& map,
                            const std::filesystem::path& truth, const std::filesystem::path& session_truth);

}  // namespace scslam
