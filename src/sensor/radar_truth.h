// The ground truth files of radar recordings.
#pragma once
#include <filesystem>

#include "scslam/core/trajectory.h"

namespace scslam {

/// Oxford Radar RobotCar, gt/radar_odometry.csv: motions of the radar from one sweep to the next (x forward, y right, z
/// down), chained from the first on; a pose's stamp is source_timestamp, the middle of its sweep. Rows that do not join
/// on to the one before start nothing new: the chain ends there.
/// @param broken_at file line of the first such row, 0 when there is none. @throw inputError file:line.
Trajectory readOxfordTruth(const std::filesystem::path& file, std::size_t& broken_at);

/// Boreas, applanix/radar_poses.csv: t [us], position east north up [m], velocity, roll pitch yaw [rad] of a radar
/// frame with z down (here: turned upright), angular velocity. @throw inputError file:line.
Trajectory readBoreasTruth(const std::filesystem::path& file);

}  // namespace scslam
