
#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "scslam/core/progress.h"
#include "scslam/mapping/map_builder.h"
#include "scslam/mapping/map_exporter.h"
#include "verb.h"

namespace scslam::cli {
namespace {

struct ExportFlags {
  std::string session, output;
  std::vector<std::string> formats;
  std::string frame = "map";
  double voxel_m = -1, min_range_m = 0, max_range_m = 1e9;
  int threads = 0;
};

void report(const MapSummary& summary, mrpt::system::COutputLogger& log) {
  const auto left_out = [&log](std::uint64_t count, const char* why) {
    if (count > 0) logInfo(log, "{} of the points {}", count, why);
  };
  if (summary.missing_scans > 0)
    logWarn(log, "{} of {} keyframes have no scan in this classic folder; they are not in the map",
            summary.missing_scans, summary.keyframes);
  if (summary.points_read > 0) logInfo(log, "{} points read", summary.points_read);
  left_out(summary.not_finite, "are not finite: left out");
  left_out(summary.out_of_range, "are out of range: left out");
  left_out(summary.thinned, "share a voxel with an earlier one: left out (--voxel 0 keeps all)");
}

int run(const ExportFlags& flags, const GlobalOptions& global) {
  Log log(verbosity(global));
  const auto& registry = Registry<MapExporter>::instance();
  for (const std::string& format : flags.formats) registry.find(format);
  ThreadPool threads(threadsOr(flags.threads));

  const Session session = Session::open(flags.session);
  if (session.scans().empty()) throw inputError("{} holds no scans yet, there is nothing to export", flags.session);
  MapOptions options;
  if (flags.voxel_m >= 0) options.voxel_m = flags.voxel_m;
  options.min_range_m = flags.min_range_m;
  options.max_range_m = flags.max_range_m;
  options.frame = flags.frame == "utm"   ? MapFrameKind::kUtm
                  : flags.frame == "enu" ? MapFrameKind::kEnu
                                         : MapFrameKind::kMap;
  const std::filesystem::path folder =
      flags.output.empty() ? session.folder() / "map" : std::filesystem::path(flags.output);
  Progress progress("keyframes", session.keyframes().size(), global.quiet);
  const MapSummary summary = exportMap(session, flags.formats, options, folder, {threads, log},
                                       [&progress](std::size_t done) { progress.update(done); });
  progress.finish();
  report(summary, log);
  for (const auto& file : summary.files)
    fmt::print("  {:<24} {:.1f} MB\n", file.filename().string(),
               static_cast<double>(std::filesystem::file_size(file)) / 1e6);
  fmt::print("map: {}\n", (summary.files.size() == 1 ? summary.files.front() : folder).string());
  return 0;
}

std::string formatList() {
  std::string list;
  for (const auto& name : Registry<MapExporter>::instance().names()) list += (list.empty() ? "" : ",") + name;
  return list;
}

}  // namespace

Verb exportVerb() {
  return {"export", "session -> maps and trajectories", [](CLI::App& app) {
            auto flags = std::make_shared<ExportFlags>();
            app.add_option("SESSION", flags->session, "session folder, ours or classic")->required();
            app.add_option("--format", flags->formats, "one or more of " + formatList())->required()->delimiter(',');
            app.add_option("--voxel", flags->voxel_m,
                           "edge of the voxels that keep one point each [m] (default: 0.1, octomap 0.2; 0: all points)")
                ->check(CLI::Range(0.0, 1000.0));
            app.add_option(
                   "--frame", flags->frame,
                   "map, enu or utm: on Earth where the session has satellite fixes; georeference.yaml says how")
                ->check(CLI::IsMember({"map", "enu", "utm"}));
            app.add_option("--min-range", flags->min_range_m, "leave out what a scan measured nearer than this [m]");
            app.add_option("--max-range", flags->max_range_m, "or further than this [m]");
            app.add_option("-o,--output", flags->output, "folder (default: SESSION/map)");
            app.add_option("--threads", flags->threads,
                           "threads (default: all cores); the result is the same for any number");
            return [flags](const GlobalOptions& global) { return run(*flags, global); };
          }};
}

}  // namespace scslam::cli
