
#include "scslam/apps/localize/localize.h"
#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "verb.h"

namespace scslam::cli {
namespace {

struct LocalizeFlags {
  LocalizeOptions options;
  std::string odometry;
  std::size_t max = 0;
  int threads = 0;
  bool json = false, dump = false;
};

std::string stemOf(const std::string& input) {
  std::filesystem::path path = std::filesystem::path(input).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  return path.stem().string();
}

int exitCode(const LocalizeSummary& summary) {
  if (summary.stopped) return static_cast<int>(ExitCode::kStopped);
  return static_cast<int>(summary.ended_early.empty() ? ExitCode::kDone : ExitCode::kEndedEarly);
}

int run(LocalizeFlags flags, const GlobalOptions& global) {
  if (flags.dump) {
    fmt::print("{}", dumpYaml(LocalizeParams{}, true));
    return 0;
  }
  LocalizeOptions& options = flags.options;
  if (options.session.empty() || options.input.empty())
    throw usageError("localize needs SESSION and INPUT; 'scslam localize --help' shows the flags");
  if (!options.session_truth.empty() && options.truth.empty())
    throw usageError("--session-gt places the map; --gt, the truth of the input, is missing");
  Log log(verbosity(global));
  ThreadPool threads(threadsOr(flags.threads));
  if (options.output.empty()) options.output = stemOf(options.input) + ".localized";
  if (flags.max > 0) options.max = flags.max;
  if (!flags.odometry.empty()) options.sets.insert(options.sets.begin(), "odometry.frontend=" + flags.odometry);
  options.quiet = global.quiet;
  options.stop = stopOnSignals();
  const LocalizeSummary summary = localize(options, {threads, log});
  if (!summary.ended_early.empty())
    logWarn(log, "the input ended early: {}; everything before it is kept", summary.ended_early);
  if (flags.json)
    fmt::print("{}", localizeJson(summary));
  else
    fmt::print("{}trajectory: {}.tum, with covariances and reasons: .csv\n", localizeTable(summary),
               options.output.string());
  return exitCode(summary);
}

}  // namespace

Verb localizeVerb() {
  return {"localize", "where in a saved session or point map is this recording? no start pose needed",
          [](CLI::App& app) {
            auto flags = std::make_shared<LocalizeFlags>();
            LocalizeOptions& options = flags->options;
            app.add_option("SESSION", options.session, "session folder, ours or classic, or a point map (.ply, .pcd)");
            app.add_option("INPUT", options.input, "what `run` reads");
            app.add_option("-o,--output", options.output,
                           "OUT of OUT.tum and OUT.csv (default: INPUT's name + .localized, here)");
            app.add_option("-c,--config", options.configs, "configuration over the session's: file or shipped name");
            app.add_option("--set", options.sets,
                           "one parameter: section.key=value (localize.confirmations=3; --dump shows the section)");
            app.add_option("--odometry", flags->odometry, "front-end (scslam list odometry)");
            app.add_option("--gt", options.truth, "true trajectory of the input, for the error");
            app.add_option("--session-gt", options.session_truth,
                           "true trajectory of the session in the same world: errors are then those relative to the "
                           "map's keyframe nearby, otherwise after laying the truth on the result");
            app.add_option("--sensor", options.sensor, "sensor table: file or shipped name");
            app.add_option("--label", options.label, "take the scans of this sensor label");
            app.add_option("--skip", options.skip, "leave out the first N scans");
            app.add_option("--max", flags->max, "take at most N scans");
            app.add_option("--threads", flags->threads,
                           "threads (default: all cores); the result is the same for any number");
            app.add_flag("--dump", flags->dump, "print the parameters of the section localize and end");
            app.add_flag("--json", flags->json, "print one JSON object on stdout and nothing else");
            return [flags](const GlobalOptions& global) { return run(*flags, global); };
          }};
}

}  // namespace scslam::cli
