#include "scslam/apps/place_recognition_source.h"

#include "scslam/core/log.h"
#include "scslam/core/progress.h"
#include "scslam/keyframe/selector.h"

namespace scslam {
namespace {

constexpr double kStampTolerance = 0.01;  // [s], as `eval`

std::optional<Pose> truthAt(const Trajectory& truth, std::size_t scan, Stamp stamp) {
  if (truth.timed) return truth.at(stamp, kStampTolerance);
  return scan < truth.poses.size() ? std::optional(truth.poses[scan].T) : std::nullopt;
}

void refuseRows(const Trajectory& truth, std::size_t scans, const std::string& what) {
  if (!truth.timed && truth.poses.size() != scans)
    throw inputError(
        "the ground truth has {} poses and no times, {} has {} scans: row i can only belong to scan i when both agree; "
        "give a TUM file (with times)",
        truth.poses.size(), what, scans);
}

void refuseWithoutTruth(const PlaceExperiment& experiment, const Trajectory& truth, const std::string& what) {
  if (experiment.withTruth() > 0) return;
  if (!truth.timed) throw inputError("no keyframe of {} has ground truth", what);
  throw inputError("no keyframe of {} has ground truth, which spans {} … {} s", what,
                   formatStamp(truth.poses.front().stamp), formatStamp(truth.poses.back().stamp));
}

}  // namespace

void addSession(PlaceExperiment& experiment, const Session& session, const Trajectory& truth, bool quiet) {
  const std::string what = session.folder().string();
  refuseRows(truth, session.scans().size(), what);
  Progress progress("places", session.keyframes().size(), quiet);
  for (const Keyframe& keyframe : session.keyframes()) {
    const Cloud cloud = transformed(session.cloud(keyframe.id), session.info().T_base_sensor);
    experiment.add(keyframe, cloud, truthAt(truth, keyframe.scan_index, keyframe.stamp));
    progress.update(keyframe.id + std::size_t{1});
  }
  refuseWithoutTruth(experiment, truth, what);
}

void addInput(PlaceExperiment& experiment, ScanSource& source, const Trajectory& truth, bool from_truth,
              const SlamParams& params, const PluginContext& context, std::optional<std::size_t> max, bool quiet) {
  if (source.size()) refuseRows(truth, *source.size(), "the input");
  const auto& frontends = Registry<Odometry>::instance();
  const auto odometry = from_truth ? frontends.create("poses", context) : params.odometry.frontend.create(context);
  odometry->begin(source.size(), source.T_base_reference());
  KeyframeSelector selector(params.keyframe);
  std::optional<std::size_t> total = source.size();
  if (max) total = total ? std::min(*total, *max) : *max;
  Progress progress("places", total, quiet);
  try {
    for (std::size_t taken = 0; !max || taken < *max; ++taken) {
      std::optional<Scan> scan = source.next();
      if (!scan) break;
      progress.update(taken + 1);
      const std::optional<Pose> T_truth_base = truthAt(truth, scan->index, scan->stamp);
      if (from_truth && !T_truth_base) continue;
      if (from_truth) scan->T_odom_base = T_truth_base;
      preprocess(*scan, params.preprocess);
      const OdometryStep step = odometry->step(*scan);
      if (!selector.isDue(step.T_odom_base, step.covariance) || step.cloud.empty()) continue;
      Keyframe keyframe;
      keyframe.id = static_cast<KeyframeId>(experiment.keyframes());
      keyframe.scan_index = scan->index;
      keyframe.stamp = scan->stamp;
      keyframe.planar = scan->planar;
      selector.accept(keyframe);
      experiment.add(keyframe, step.cloud, T_truth_base);
    }
  } catch (const Error& error) {
    if (error.code() != ExitCode::kInput || experiment.keyframes() == 0) throw;
    logWarn(context.log, "the input ended early: {}; what came before it is measured", error.what());
  }
  progress.finish();
  refuseWithoutTruth(experiment, truth, "the input");
}

}  // namespace scslam
