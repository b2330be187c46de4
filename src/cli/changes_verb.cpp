
#include "scslam/apps/changes/changes.h"
#include "scslam/core/file.h"
#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "scslam/view/changes_png.h"
#include "verb.h"

namespace scslam::cli {
namespace {

struct ChangesFlags {
  ChangesOptions options;
  int threads = 0;
  bool json = false, dump = false;
};

int run(ChangesFlags flags, const GlobalOptions& global) {
  if (flags.dump) {
    fmt::print("{}", dumpYaml(ChangeParams{}, true));
    return 0;
  }
  ChangesOptions& options = flags.options;
  if (options.session.empty()) throw usageError("changes needs SESSION; 'scslam changes --help' shows the flags");
  Log log(verbosity(global));
  ThreadPool threads(threadsOr(flags.threads));
  options.quiet = global.quiet;
  options.stop = stopOnSignals();
  const ChangesSummary summary = findChanges(options, {threads, log});
  writeFileAtomically(summary.folder / "changes.png", changesPng(summary.map));
  if (flags.json) {
    fmt::print("{}", changesJson(summary));
    return 0;
  }
  fmt::print("{}picture: {} (green: appeared, red: disappeared)\nmap: {}\n", changesTable(summary),
             (summary.folder / "changes.png").string(), (summary.folder / "changes.ply").string());
  return 0;
}

}  // namespace

Verb changesVerb() {
  return {"changes", "merged session -> what appeared, what disappeared, what stayed", [](CLI::App& app) {
            auto flags = std::make_shared<ChangesFlags>();
            app.add_option("SESSION", flags->options.session, "a session made by merge; it stays as it is");
            app.add_option("--older", flags->options.older, "parent of the session (default: its first)");
            app.add_option("--newer", flags->options.newer, "parent to compare it with (default: its last)");
            app.add_option("-o,--output", flags->options.output, "folder (default: SESSION/changes)");
            app.add_option("--set", flags->options.sets, "one parameter: key=value (--dump shows all)");
            app.add_option("--threads", flags->threads,
                           "threads (default: all cores); the result is the same for any number");
            app.add_flag("-w,--overwrite", flags->options.overwrite, "replace an earlier comparison");
            app.add_flag("--dump", flags->dump, "print the parameters and end");
            app.add_flag("--json", flags->json, "print one JSON object on stdout and nothing else");
            return [flags](const GlobalOptions& global) { return run(*flags, global); };
          }};
}

}  // namespace scslam::cli
