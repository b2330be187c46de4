// MulRan's global_pose.csv.
#pragma once
#include <filesystem>
#include <string>

#include "scslam/core/trajectory.h"

namespace scslam {

/// global_pose.csv in `folder`, above it, or in its sensor_data; empty when it is nowhere there.
std::filesystem::path findMulranPoses(const std::filesystem::path& folder);

/// Poses T_map_base of the car body relative to the first position: UTM coordinates of 10^6 m leave no digits for a
/// float. @param description what was read, for people. @throw inputError file:line.
Trajectory readMulranPoses(const std::filesystem::path& file, std::string& description);

}  // namespace scslam
