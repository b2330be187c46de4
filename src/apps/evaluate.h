// A session against the truth: the figures of `scslam eval`.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "scslam/apps/trajectory_error.h"
#include "scslam/session/session.h"

namespace scslam {

struct EvaluationOptions {
  double revisit_radius_m = 3.0;                  ///< a keyframe this near an earlier one revisits it
  double revisit_min_travel_m = 15.0;             ///< … when at least this much way lies between them
  double loop_trans_m = 1.0, loop_rot_deg = 5.0;  ///< a loop within these of the truth is true
  double stamp_tolerance_s = 0.01;                ///< how far outside the truth's time span a scan may lie
};

/// An accepted loop that the truth contradicts.
struct FalseLoop {
  KeyframeId query = 0, match = 0;
  double trans_m = 0, rot_deg = 0;  ///< how far its measured pose is from the true one
};

struct LoopFigures {
  std::size_t candidates = 0, accepted = 0;
  std::size_t true_accepted = 0, false_accepted = 0;  ///< accepted loops without truth at both ends are neither
  std::vector<FalseLoop> false_loops;                 ///< one by one
  std::size_t revisits = 0, revisits_closed = 0;      ///< keyframes that revisit; with a true accepted loop
  std::optional<double> precision, recall;            ///< absent where there is nothing to count
  double revisit_radius_m = 0;
};

struct Evaluation {
  AbsoluteError ate, odometry_ate;  ///< every scan that has truth
  AbsoluteError keyframe_ate;       ///< keyframes alone
  RelativeError rpe, odometry_rpe;
  RelativeError level_rpe, odometry_level_rpe;  ///< of x, y and heading, where planar
  std::size_t poses = 0, scans = 0;             ///< with truth, and all
  std::string alignment;                        ///< how it was aligned, for people
  bool planar = false;                          ///< 2-D data: heights are not measured
  LoopFigures loops;
  std::vector<std::optional<Pose>> T_truth_base;  ///< per scan
};

/// @param truth poses of the base in a frame of its own. Timed: interpolated at each scan's stamp. Untimed (KITTI): row
/// i belongs to scan i, so that there must be as many rows as scans.
/// @throw inputError when the counts do not agree, or no scan lies in the truth's time span (both spans are named).
Evaluation evaluate(const Session& session, const Trajectory& truth, const EvaluationOptions& options = {});

/// One JSON object with the keys of README, "scslam eval".
std::string evaluationJson(const Evaluation& evaluation);
/// A small table, before and after.
std::string evaluationTable(const Evaluation& evaluation);

}  // namespace scslam
