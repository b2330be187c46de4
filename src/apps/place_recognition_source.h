// Keyframes for a place recognition experiment, from a session or made from an input.
#pragma once
#include "scslam/apps/place_recognition.h"
#include "scslam/core/trajectory.h"
#include "scslam/sensor/scan_source.h"
#include "scslam/session/session.h"

namespace scslam {

/// The session's keyframes and clouds, attitudes from its odometry.
/// @param truth T_truth_base. Untimed: row i belongs to scan i of the session.
/// @throw inputError when no keyframe has truth, an untimed truth does not fit, or a cloud is missing.
void addSession(PlaceExperiment& experiment, const Session& session, const Trajectory& truth, bool quiet);

/// Keyframes of an input by the same preprocessing, front-end and selection as `run` makes them.
/// @param from_truth the front-end is `poses`, fed with the truth itself: places without any drift, no registration.
/// Scans outside the truth are then left out. Otherwise params.odometry drives.
/// @param max scans taken at most. A damaged end of the input is reported by the log and ends the stream.
void addInput(PlaceExperiment& experiment, ScanSource& source, const Trajectory& truth, bool from_truth,
              const SlamParams& params, const PluginContext& context, std::optional<std::size_t> max, bool quiet);

}  // namespace scslam
