// What the pipeline tells the session, one record per event. The journal is the list of these records.
#pragma once
#include <string>
#include <vector>

#include "scslam/graph/pose_graph.h"
#include "scslam/keyframe/keyframe.h"
#include "scslam/sensor/navigation.h"

namespace scslam {

/// Every scan, used or not.
struct ScanRecord {
  std::size_t index = 0;
  Stamp stamp;
  Pose T_odom_base = Pose::Identity();
  std::int64_t keyframe = -1;  ///< newest keyframe at this scan (the scan's own when it became one)
};

/// Every loop candidate, with its figures and the reason for its verdict: one row of loops.csv.
struct LoopRecord {
  KeyframeId query = 0, match = 0;
  std::string recogniser;
  double distance = 0;       ///< descriptor distance
  double yaw_guess_rad = 0;  ///< the recogniser's
  double rmse_m = 0, inlier_ratio = 1, explained = 0, overlap = 0;
  int unfixed_axes = 0;                         ///< directions the overlap leaves open; the factor says nothing of them
  bool free_space_checked = false;              ///< the gates before passed
  double target_overlap = 0, seen_through = 0;  ///< registration/loop_gates.h; the larger share of both directions
  double odometry_mahalanobis2 =
      0;  ///< disagreement with odometry's own uncertainty, chi2 with 6 degrees of freedom (3 if planar)
  bool registered = false;  ///< registration was tried (the gates before it passed)
  bool verified = false;    ///< passed its own gates; whether it is accepted then depends on the other loops
  bool accepted = false;
  std::string reason;                       ///< "accepted" or the gate that refused, with the figure
  Pose T_match_query = Pose::Identity();    ///< measured, when registered
  Matrix6d information = Matrix6d::Zero();  ///< of it, when registered
};

/// A loop that was accepted or refused before and is judged otherwise now.
struct LoopVerdict {
  std::uint32_t loop = 0;  ///< index among the session's LoopRecords
  bool accepted = false;
  std::string reason;
};

/// A satellite fix, tied to the keyframe before it.
struct GnssRecord {
  KeyframeId keyframe = 0;
  GnssFix fix;
  /// Where odometry says the antenna was at the fix's time, in the base frame of the keyframe.
  Eigen::Vector3d antenna_in_keyframe_m = Eigen::Vector3d::Zero();
};

}  // namespace scslam
