
#include "scslam/apps/clean/clean.h"
#include "scslam/core/file.h"
#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "scslam/view/top_view_png.h"
#include "verb.h"

namespace scslam::cli {
namespace {

struct CleanFlags {
  CleanOptions options;
  std::string label_style = "semantickitti";
  int threads = 0;
  bool json = false, dump = false;
};

int run(CleanFlags flags, const GlobalOptions& global) {
  if (flags.dump) {
    fmt::print("{}", dumpYaml(CleanParams{}, true));
    return 0;
  }
  CleanOptions& options = flags.options;
  if (options.session.empty()) throw usageError("clean needs SESSION; 'scslam clean --help' shows the flags");
  Log log(verbosity(global));
  ThreadPool threads(threadsOr(flags.threads));
  options.label_style = flags.label_style == "pandaset" ? LabelStyle::kPandaSet : LabelStyle::kSemanticKitti;
  options.quiet = global.quiet;
  options.stop = stopOnSignals();
  const CleanSummary summary = cleanSession(options, {threads, log});

  const Session stays = Session::open(summary.folder / "static"), goes = Session::open(summary.folder / "dynamic");
  TopViewOptions view;
  view.marked = &goes;
  writeFileAtomically(summary.folder / "clean.png", topViewPng(stays, view));
  if (flags.json) {
    fmt::print("{}", cleanJson(summary));
    return 0;
  }
  fmt::print("{}picture: {} (red: removed)\nmap: {}\n", cleanTable(summary), (summary.folder / "clean.png").string(),
             (summary.folder / "static" / "map" / "map.ply").string());
  return 0;
}

}  // namespace

Verb cleanVerb() {
  return {"clean", "saved session -> the same without what moved, and its map", [](CLI::App& app) {
            auto flags = std::make_shared<CleanFlags>();
            app.add_option("SESSION", flags->options.session, "session folder, ours or classic; it stays as it is");
            app.add_option("-o,--output", flags->options.output,
                           "folder of the sessions static and dynamic (default: SESSION/clean)");
            app.add_option("-c,--config", flags->options.configs,
                           "configuration over the session's own: file or shipped name");
            app.add_option("--set", flags->options.sets,
                           "one parameter: section.key=value (clean.later_views=24; --dump shows the section clean)");
            app.add_option("--gt-labels", flags->options.labels,
                           "folder of the true labels of all scans (NNNNNN.label, uint32 per point), for the scores");
            app.add_option("--gt-label-style", flags->label_style,
                           "semantickitti: classes 252 to 259 move; pandaset: upper half 1 moves")
                ->check(CLI::IsMember({"semantickitti", "pandaset"}));
            app.add_option("--threads", flags->threads,
                           "threads (default: all cores); the result is the same for any number");
            app.add_flag("-w,--overwrite", flags->options.overwrite, "replace an earlier cleaning");
            app.add_flag("--dump", flags->dump, "print the parameters of the section clean and end");
            app.add_flag("--json", flags->json, "print one JSON object on stdout and nothing else");
            return [flags](const GlobalOptions& global) { return run(*flags, global); };
          }};
}

}  // namespace scslam::cli
