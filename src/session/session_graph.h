// What a session's records say as trajectories and as a pose graph.
#pragma once
#include <vector>

#include "scslam/core/trajectory.h"
#include "scslam/session/records.h"

namespace scslam {

/// Step variance [m^2] from which on a keyframe does not follow the one before by odometry: where a merged session goes
/// on with its next parent.
inline constexpr double kOpenStep = 1e6;

/// Odometry factors between consecutive keyframes (information = inverse step covariance) and accepted loops, over
/// T_map_base. A step of which nothing is known (kOpenStep) is no factor. A step without a usable covariance (classic
/// sessions have none) counts as 5 cm and 0.5 deg.
PoseGraph buildGraph(const std::vector<Keyframe>& keyframes, const std::vector<LoopRecord>& loops,
                     const std::vector<Pose>& T_map_base, bool planar);

/// The same graph over the sensor's poses T_map_sensor = T_map_base * T_base_sensor: nodes, measurements and
/// information. The classic tools pair each vertex with a scan in the sensor frame.
PoseGraph graphOfSensor(PoseGraph graph, const Pose& T_base_sensor);

/// T_map_base of every scan: the correction of its keyframe applied to its odometry. Before the first keyframe: its
/// odometry.
std::vector<StampedPose> correctedTrajectory(const std::vector<ScanRecord>& scans,
                                             const std::vector<Keyframe>& keyframes,
                                             const std::vector<Pose>& T_map_base);
std::vector<StampedPose> odometryTrajectory(const std::vector<ScanRecord>& scans);

}  // namespace scslam
