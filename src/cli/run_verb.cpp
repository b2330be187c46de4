#include <cmath>
#include <functional>

#include "scslam/apps/evaluate.h"
#include "scslam/apps/run_job.h"
#include "scslam/core/file.h"
#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "scslam/view/top_view_png.h"
#include "scslam/view/trajectory_svg.h"
#include "verb.h"

namespace scslam::cli {
namespace {

struct RunFlags {
  RunOptions job;
  std::string odometry, poses, ground_truth, output;
  std::size_t max = 0;
  int threads = 0;
  bool json = false;
  std::vector<std::string> plugins;
};

std::string lowerStem(const std::string& input) {
  std::filesystem::path path(input);
  if (path.filename().empty()) path = path.parent_path();
  return path.stem().string();
}

int exitCode(const RunSummary& summary) {
  switch (summary.end) {
    case SessionEnd::kStopped:
      return static_cast<int>(ExitCode::kStopped);
    case SessionEnd::kEndedEarly:
      return static_cast<int>(ExitCode::kEndedEarly);
    case SessionEnd::kDone:
      break;
  }
  return static_cast<int>(ExitCode::kDone);
}

/// How far the accepted loops are from agreeing with a trajectory, rms [m]: a figure that needs no ground truth.
double loopMisfit(const Session& session, const std::function<const Pose&(KeyframeId)>& T_world_base) {
  double sum = 0;
  std::size_t loops = 0;
  for (const LoopRecord& loop : session.loops()) {
    if (!loop.accepted) continue;
    const Pose T_match_query = T_world_base(loop.match).inverse() * T_world_base(loop.query);
    sum += local(loop.T_match_query, T_match_query).head<3>().squaredNorm();
    ++loops;
  }
  return loops > 0 ? std::sqrt(sum / static_cast<double>(loops)) : 0;
}

void printTable(const RunSummary& s, const Session& session, const std::optional<Evaluation>& evaluation) {
  const auto row = [](const char* name, const std::string& value) { fmt::print("  {:<22} {}\n", name, value); };
  fmt::print("\n");
  row("scans", fmt::format("{} ({:.1f} s of recording)", s.counts.scans, s.input_duration_s));
  if (s.counts.empty_scans + s.counts.late_scans + s.counts.lost_scans > 0)
    row("of these", fmt::format("{} without points, {} left out for their time (in addition), {} without odometry",
                                s.counts.empty_scans, s.counts.late_scans, s.counts.lost_scans));
  row("keyframes", std::to_string(s.counts.keyframes));
  row("loops", fmt::format("{} accepted of {} candidates (loops.csv says why)", s.counts.loops, s.counts.candidates));
  row("time", fmt::format("{:.1f} s, {:.1f} x real time; {:.1f} ms a scan (95 %: {:.1f} ms)", s.wall_s,
                          s.wall_s > 0 ? s.input_duration_s / s.wall_s : 0, s.ms_per_scan_median, s.ms_per_scan_p95));
  row("memory", fmt::format("{:.0f} MB at most", s.peak_rss_mb));
  if (s.counts.loops > 0) {
    const auto odometry = [&session](KeyframeId k) -> const Pose& { return session.keyframes()[k].T_odom_base; };
    const auto optimised = [&session](KeyframeId k) -> const Pose& { return session.poses()[k]; };
    row("loops disagree by", fmt::format("{:.3f} m before, {:.3f} m after (rms)", loopMisfit(session, odometry),
                                         loopMisfit(session, optimised)));
  }
  if (evaluation) {
    row("odometry ATE", fmt::format("{:.3f} m (before)", evaluation->odometry_ate.rmse_m));
    row("map ATE", fmt::format("{:.3f} m (after)", evaluation->ate.rmse_m));
  }
}

/// @return the accuracy, where there is a truth to measure it by.
std::optional<Evaluation> addPictures(const Session& session, const std::optional<Trajectory>& ground_truth, Log& log) {
  std::optional<Evaluation> evaluation;
  if (ground_truth) {
    try {
      evaluation = evaluate(session, *ground_truth);
    } catch (const Error& error) {
      logWarn(log, "no accuracy figures: {}", error.what());
    }
  }
  writeFileAtomically(session.folder() / "trajectory.svg", trajectorySvg(session, ground_truth));
  writeFileAtomically(session.folder() / "map_top.png", topViewPng(session));
  return evaluation;
}

int run(RunFlags flags, const GlobalOptions& global) {
  Log log(verbosity(global));
  for (const auto& plugin : flags.plugins) loadPlugin(plugin);
  ThreadPool threads(threadsOr(flags.threads));
  const PluginContext context{threads, log};

  RunOptions& job = flags.job;
  job.output = flags.output.empty() ? lowerStem(job.input) + ".session" : flags.output;
  job.quiet = global.quiet;
  if (flags.max > 0) job.max = flags.max;
  std::vector<std::string> sets;
  if (!flags.odometry.empty()) sets.push_back("odometry.frontend=" + flags.odometry);
  if (!flags.poses.empty()) {
    if (flags.odometry.empty()) sets.emplace_back("odometry.frontend=poses");
    sets.push_back("odometry.poses.file=\"" + flags.poses + "\"");
  }
  job.sets.insert(job.sets.begin(), sets.begin(), sets.end());
  std::optional<Trajectory> ground_truth;
  if (!flags.ground_truth.empty()) ground_truth = readTrajectory(flags.ground_truth);
  job.stop = stopOnSignals();

  std::optional<Evaluation> evaluation;
  job.add = [&](const RunSummary& finished) {
    ground_truth = ground_truth ? inBaseFrame(*ground_truth, finished.T_base_reference) : finished.ground_truth;
    evaluation = addPictures(Session::open(finished.session), ground_truth, log);
  };
  const RunSummary summary = runJob(job, context);
  if (summary.end == SessionEnd::kEndedEarly)
    logWarn(log, "the input ended early: {}; everything before it is kept", summary.end_reason);
  if (summary.end == SessionEnd::kStopped)
    logWarn(log, "stopped; the session is complete up to here, --resume goes on");
  if (flags.json) {
    fmt::print("{}", summary.metrics_json);
  } else {
    printTable(summary, Session::open(summary.session), evaluation);
    fmt::print("pictures: {}, map_top.png\nsession: {}  (map: scslam export {} --format ply)\n",
               (summary.session / "trajectory.svg").string(), summary.session.string(), summary.session.string());
  }
  return exitCode(summary);
}

}  // namespace

Verb runVerb() {
  return {
      "run", "input -> session: odometry, places, loops, graph", [](CLI::App& app) {
        auto flags = std::make_shared<RunFlags>();
        app.add_option("INPUT", flags->job.input, "rawlog, KITTI / MulRan / PCD-PLY-BIN-XYZ folder, or session")
            ->required();
        app.add_option("-c,--config", flags->job.configs, "configuration: file or shipped name (scslam list configs)");
        app.add_option("--set", flags->job.sets, "one parameter: section.key=value (scslam config dump shows all)");
        app.add_option("-o,--output", flags->output, "session folder (default: INPUT's name + .session, here)");
        app.add_option("--odometry", flags->odometry, "front-end (scslam list odometry)");
        app.add_option("--poses", flags->poses, "external odometry: TUM or KITTI file beside the scans");
        app.add_option("--gt", flags->ground_truth, "true trajectory (TUM or KITTI) for the figures before / after");
        app.add_option("--sensor", flags->job.sensor, "sensor table: file or shipped name (scslam list sensors)");
        app.add_option("--label", flags->job.label, "take the scans of this sensor label");
        app.add_option("--skip", flags->job.skip, "leave out the first N scans");
        app.add_option("--max", flags->max, "take at most N scans");
        app.add_option("--threads", flags->threads,
                       "threads (default: all cores); the result is the same for any number");
        app.add_flag("--resume", flags->job.resume, "go on with a session that was stopped or killed");
        app.add_flag("-w,--overwrite", flags->job.overwrite, "replace an existing session");
        app.add_option("--plugin", flags->plugins, "load a library with front-ends, readers, … of your own");
        app.add_flag("--json", flags->json, "print metrics.json on stdout and nothing else");
        return [flags](const GlobalOptions& global) { return run(*flags, global); };
      }};
}

}  // namespace scslam::cli
