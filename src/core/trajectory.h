// A time-ordered list of poses, and the text forms everybody exchanges: TUM, KITTI, EuRoC.
#pragma once
#include <filesystem>
#include <optional>
#include <vector>

#include "scslam/core/pose.h"
#include "scslam/core/stamp.h"

namespace scslam {

struct StampedPose {
  Stamp stamp;
  Pose T = Pose::Identity();
};

struct Trajectory {
  std::vector<StampedPose> poses;  ///< strictly increasing stamps when `timed`
  bool timed = true;               ///< false: a KITTI file, row i belongs to scan i

  /// Pose at `stamp`, interpolated; nullopt outside [first - tolerance, last + tolerance] or in a gap longer than
  /// max_gap_s.
  std::optional<Pose> at(Stamp stamp, double tolerance_s = 0.01, double max_gap_s = 5.0) const;
};

/// Reads a TUM file ("stamp x y z qx qy qz qw"), a KITTI file (12 numbers, row-major 3x4) or an EuRoC table (commas;
/// nanoseconds, x, y, z, qw, qx, qy, qz, …); guesses which by the first row. Comment lines (#) and blank lines are
/// skipped. @throw inputError with file:line for anything else.
Trajectory readTrajectory(const std::filesystem::path& file);
/// Poses of a reference frame (T_world_reference) to poses of the base: T_world_base = T_world_reference *
/// T_base_reference^-1.
Trajectory inBaseFrame(Trajectory trajectory, const Pose& T_base_reference);
/// TUM, 9-decimal stamps, 17 significant digits.
std::string formatTum(const std::vector<StampedPose>& poses);
/// KITTI, 12 numbers a line, 17 significant digits.
std::string formatKitti(const std::vector<Pose>& poses);

}  // namespace scslam
