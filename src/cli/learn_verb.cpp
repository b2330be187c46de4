
#include "scslam/apps/learn/learn_quality.h"
#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "verb.h"

namespace scslam::cli {
namespace {

struct LearnFlags {
  LearnOptions options;
  int threads = 0;
};

int run(LearnFlags flags, const GlobalOptions& global) {
  Log log(verbosity(global));
  ThreadPool threads(threadsOr(flags.threads));
  flags.options.quiet = global.quiet;
  flags.options.stop = stopOnSignals();
  fmt::print("{}", learnYaml(learnQuality(flags.options, {threads, log}), flags.options));
  return 0;
}

}  // namespace

Verb learnVerb() {
  return {"learn", "sessions with truth -> the weights of registration.gates.quality, as YAML", [](CLI::App& app) {
            auto flags = std::make_shared<LearnFlags>();
            app.add_option("SESSION", flags->options.sessions, "one or more, simulated ones say")->required();
            app.add_option("--gt", flags->options.truths, "true trajectory of each, in the order of the sessions")
                ->take_all()
                ->required();
            app.add_option("--set", flags->options.sets, "one parameter over those of the sessions: section.key=value");
            app.add_option("--threads", flags->threads,
                           "threads (default: all cores); the result is the same for any number");
            return [flags](const GlobalOptions& global) { return run(*flags, global); };
          }};
}

}  // namespace scslam::cli
