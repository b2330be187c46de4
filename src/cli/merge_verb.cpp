
#include "scslam/apps/merge/merge.h"
#include "scslam/core/file.h"
#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "scslam/session/session.h"
#include "scslam/view/merge_svg.h"
#include "scslam/view/top_view_png.h"
#include "verb.h"

namespace scslam::cli {
namespace {

struct MergeFlags {
  MergeOptions options;
  int threads = 0;
  bool json = false, dump = false;
};

int run(MergeFlags flags, const GlobalOptions& global) {
  if (flags.dump) {
    fmt::print("{}", dumpYaml(MergeParams{}, true));
    return 0;
  }
  if (flags.options.output.empty()) throw usageError("-o is missing: the folder of the merged session");
  Log log(verbosity(global));
  ThreadPool threads(threadsOr(flags.threads));
  flags.options.quiet = global.quiet;
  flags.options.stop = stopOnSignals();
  const MergeSummary summary = mergeSessions(flags.options, {threads, log});
  for (const MergedParent& parent : summary.parents)
    if (!parent.joined)
      logWarn(log, "{} is not joined to the sessions of the result and stays separate", parent.folder.string());

  const std::filesystem::path folder = flags.options.output;
  const Session session = Session::open(folder);
  writeFileAtomically(folder / "merge.svg", mergeSvg(session, summary));
  writeFileAtomically(folder / "map_top.png", topViewPng(session));
  if (flags.json) {
    fmt::print("{}", mergeJson(summary));
    return 0;
  }
  fmt::print("{}pictures: {}, map_top.png\nsession: {}  (map: scslam export {} --format ply)\n", mergeTable(summary),
             (folder / "merge.svg").string(), folder.string(), folder.string());
  return 0;
}

}  // namespace

Verb mergeVerb() {
  return {"merge", "saved sessions and point maps -> one session in one frame, without start poses", [](CLI::App& app) {
            auto flags = std::make_shared<MergeFlags>();
            app.add_option("SESSION", flags->options.sessions,
                           "two or more, any order: session folders, ours or classic, and point maps (.ply, .pcd) made "
                           "by others, whose frame is then the result's");
            app.add_option("-o,--output", flags->options.output, "folder of the merged session");
            app.add_option("-c,--config", flags->options.configs,
                           "configuration over that of the longest session: file or shipped name");
            app.add_option("--set", flags->options.sets,
                           "one parameter: section.key=value (merge.min_loops=4; --dump shows the section merge)");
            app.add_option("--gt", flags->options.truths,
                           "true trajectory of each session in one world frame, in the order of the sessions, for the "
                           "figures")
                ->take_all();
            app.add_option("--threads", flags->threads,
                           "threads (default: all cores); the result is the same for any number");
            app.add_flag("-w,--overwrite", flags->options.overwrite, "replace an existing session");
            app.add_flag("--dump", flags->dump, "print the parameters of the section merge and end");
            app.add_flag("--json", flags->json, "print one JSON object on stdout and nothing else");
            return [flags](const GlobalOptions& global) { return run(*flags, global); };
          }};
}

}  // namespace scslam::cli
