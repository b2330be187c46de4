#include <cmath>

#include "scslam/apps/evaluate.h"
#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "scslam/sensor/scan_source.h"
#include "verb.h"

namespace scslam::cli {
namespace {

struct EvalFlags {
  std::string session, ground_truth, frame = "base";
  EvaluationOptions options;
  double max_ate_m = INFINITY;
  bool json = false;
};

/// T_map_base * T_base_frame of each pose, back to T_map_base.
Trajectory toBase(Trajectory truth, const Pose& T_base_frame) {
  const Pose T_frame_base = T_base_frame.inverse();
  for (StampedPose& pose : truth.poses) pose.T = pose.T * T_frame_base;
  return truth;
}

Trajectory readTruth(const EvalFlags& flags, const Session& session, const PluginContext& context) {
  const bool trajectory_file = std::filesystem::is_regular_file(flags.ground_truth) &&
                               std::filesystem::path(flags.ground_truth).extension() != ".rawlog";
  if (!trajectory_file) {
    const OpenedSource opened = openSource(flags.ground_truth, context);
    std::optional<Trajectory> truth = opened.source->groundTruth();
    if (!truth)
      throw inputError("{} ({}) holds no ground truth; give a TUM or KITTI file", flags.ground_truth, opened.format);
    return *std::move(truth);  // readers speak of the base
  }
  Trajectory truth = readTrajectory(flags.ground_truth);
  if (flags.frame == "sensor") return toBase(std::move(truth), session.info().T_base_sensor);
  if (flags.frame == "input")
    return toBase(std::move(truth), openSource(session.info().input, context).source->T_base_reference());
  return truth;
}

int run(const EvalFlags& flags, const GlobalOptions& global) {
  Log log(global.verbose ? mrpt::system::LVL_DEBUG : mrpt::system::LVL_WARN);
  ThreadPool threads(1);
  const Session session = Session::open(flags.session);
  const Evaluation evaluation = evaluate(session, readTruth(flags, session, {threads, log}), flags.options);
  fmt::print("{}", flags.json ? evaluationJson(evaluation) : evaluationTable(evaluation));
  if (evaluation.ate.rmse_m > flags.max_ate_m) {
    fmt::print(stderr, "gate failed: ATE {:.3f} m is more than {:g} m\n", evaluation.ate.rmse_m, flags.max_ate_m);
    return static_cast<int>(ExitCode::kQualityGate);
  }
  if (!flags.json) fmt::print("session: {}\n", session.folder().string());
  return 0;
}

}  // namespace

Verb evalVerb() {
  return {"eval", "session against ground truth: ATE, RPE, loops", [](CLI::App& app) {
            auto flags = std::make_shared<EvalFlags>();
            app.add_option("SESSION", flags->session, "session folder, ours or classic")->required();
            app.add_option("--gt", flags->ground_truth,
                           "true trajectory: TUM or KITTI file, or an input that has one (folder, rawlog)")
                ->required();
            app.add_option(
                   "--gt-frame", flags->frame,
                   "whose poses the file holds: base (default), sensor (moved by the session's T_base_sensor), or "
                   "input (the frame of pose files beside the session's input; KITTI with calib.txt: camera)")
                ->check(CLI::IsMember({"base", "sensor", "input"}));
            app.add_option("--revisit-radius", flags->options.revisit_radius_m,
                           "a keyframe this near an earlier one counts as a revisit [m] (default: 3)")
                ->check(CLI::PositiveNumber);
            app.add_option("--max-ate", flags->max_ate_m, "exit with 5 when the ATE is more than this [m]");
            app.add_flag("--json", flags->json, "print one JSON object on stdout and nothing else");
            return [flags](const GlobalOptions& global) { return run(*flags, global); };
          }};
}

}  // namespace scslam::cli
