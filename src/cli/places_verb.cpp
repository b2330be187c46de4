// scslam places: recognition alone, on a session or any input with truth.
#include <algorithm>

#include "scslam/apps/place_recognition_source.h"
#include "scslam/apps/run_job.h"
#include "scslam/core/file.h"
#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "scslam/view/curve_svg.h"
#include "verb.h"

namespace scslam::cli {
namespace {

struct PlacesFlags {
  std::string input, ground_truth, odometry, label, svg;
  std::vector<std::string> recognisers, variants, configs, sets, plugins;
  PlaceOptions options;
  std::size_t max = 0;
  int threads = 0;
  bool json = false;
};

bool isSession(const std::filesystem::path& path) {
  return std::filesystem::is_regular_file(path / "session.yaml") ||
         std::filesystem::is_regular_file(path / "optimized_poses.txt");
}

/// Defaults, then the profile that fits the data, then files, then --set.
SlamParams paramsOf(const PlacesFlags& flags, bool planar) {
  SlamParams params;
  if (planar) loadConfig(params, "laser2d");
  for (const auto& config : flags.configs) loadConfig(params, config);
  for (const auto& assignment : flags.sets) setParam(params, assignment);
  if (!flags.odometry.empty()) setParam(params, "odometry.frontend=" + flags.odometry);
  return params;
}

PlaceExperiment experimentOf(const PlacesFlags& flags, const SlamParams& params, const PluginContext& context) {
  std::vector<std::string> texts = flags.recognisers;
  texts.insert(texts.end(), flags.variants.begin(), flags.variants.end());
  if (texts.empty()) texts = params.place.recognisers.names;
  if (texts.empty()) throw usageError("the configuration names no place recogniser; give --recogniser");
  std::vector<PlaceVariant> variants;
  for (const auto& text : texts) variants.push_back(placeVariant(text, params, flags.options));
  PlaceOptions options = flags.options;
  options.registration = params.registration;
  return {variants, options, context};
}

/// A trajectory file, in the base frame of `T_base_reference`; or an input that carries its own truth.
std::optional<Trajectory> givenTruth(const PlacesFlags& flags, const Pose& T_base_reference,
                                     const PluginContext& context) {
  if (flags.ground_truth.empty()) return std::nullopt;
  const std::filesystem::path path(flags.ground_truth);
  if (std::filesystem::is_directory(path) || path.extension() == ".rawlog") {
    auto truth = openSource(path, context).source->groundTruth();
    if (!truth) throw inputError("{} holds no ground truth; give a TUM or KITTI file", flags.ground_truth);
    return truth;
  }
  return inBaseFrame(readTrajectory(path), T_base_reference);
}

PlaceReport measureSession(const PlacesFlags& flags, const PluginContext& context, bool quiet) {
  if (!flags.odometry.empty()) throw usageError("--odometry: a session has its keyframes already");
  const Session session = Session::open(flags.input);
  const auto truth = givenTruth(flags, Pose::Identity(), context);
  if (!truth) throw usageError("--gt: a session needs a true trajectory (TUM, KITTI, or the input it was made from)");
  PlaceExperiment experiment = experimentOf(flags, paramsOf(flags, session.info().planar), context);
  addSession(experiment, session, *truth, quiet);
  return {flags.input,   "the session",       experiment.keyframes(), experiment.withTruth(),
          flags.options, experiment.figures()};
}

PlaceReport measureInput(const PlacesFlags& flags, const PluginContext& context, bool quiet) {
  OpenOptions open;
  open.label = flags.label;
  const OpenedSource opened = openSource(flags.input, context, open);
  ScanSource& source = *opened.source;
  logInfo(context.log, "input: {} ({}): {}", opened.format, opened.why, source.description());
  auto truth = givenTruth(flags, source.T_base_reference(), context);
  if (!truth) truth = source.groundTruth();
  if (!truth) throw usageError("--gt: {} carries no truth of its own; give a TUM or KITTI file", flags.input);
  const SlamParams params = paramsOf(flags, source.planar());
  PlaceExperiment experiment = experimentOf(flags, params, context);
  const bool from_truth = flags.odometry.empty();
  addInput(experiment, source, *truth, from_truth, params, context,
           flags.max > 0 ? std::optional(flags.max) : std::nullopt, quiet);
  return {flags.input,
          from_truth ? "the true trajectory" : flags.odometry,
          experiment.keyframes(),
          experiment.withTruth(),
          flags.options,
          experiment.figures()};
}

int run(const PlacesFlags& flags, const GlobalOptions& global) {
  Log log(verbosity(global));
  for (const auto& plugin : flags.plugins) loadPlugin(plugin);
  ThreadPool threads(threadsOr(flags.threads));
  const PluginContext context{threads, log};
  const PlaceReport report = isSession(flags.input) ? measureSession(flags, context, global.quiet)
                                                    : measureInput(flags, context, global.quiet);
  if (!flags.svg.empty()) writeFileAtomically(flags.svg, placesSvg(report));
  fmt::print("{}", flags.json ? placeJson(report) : placeTable(report));
  if (!flags.svg.empty() && !flags.json) fmt::print("picture: {}\n", flags.svg);
  return 0;
}

}  // namespace

Verb placesVerb() {
  return {"places", "place recognition alone against the truth: precision-recall, recall@1, by heading and offset",
          [](CLI::App& app) {
            auto flags = std::make_shared<PlacesFlags>();
            app.add_option("INPUT", flags->input, "session, or anything `run` takes")->required();
            app.add_option("--gt", flags->ground_truth,
                           "true trajectory: TUM or KITTI file, or an input that has one (default: the input's own)");
            app.add_option("--recogniser", flags->recognisers,
                           "which, separated by commas (default: the configuration's; scslam list recognisers)")
                ->delimiter(',');
            app.add_option("--variant", flags->variants,
                           "a recogniser with parameters: scan_context:rings=40,sectors=60; may be repeated")
                ->allow_extra_args(false);
            app.add_option("--odometry", flags->odometry,
                           "make the keyframes with this front-end (default: from the true trajectory)");
            app.add_option("-c,--config", flags->configs, "configuration: file or shipped name");
            app.add_option("--set", flags->sets, "one parameter: section.key=value")->allow_extra_args(false);
            app.add_option("--revisit-radius", flags->options.revisit_radius_m,
                           "a candidate truly this near is the same place [m] (default: 3)")
                ->check(CLI::PositiveNumber);
            app.add_option("--split-radius", flags->options.split_radius_m,
                           "likewise, for the figures by heading and offset [m] (default: 8)")
                ->check(CLI::PositiveNumber);
            app.add_option("--min-travel", flags->options.min_travel_m,
                           "way that must lie between both visits [m] (default: 15)")
                ->check(CLI::NonNegativeNumber);
            app.add_option("--label", flags->label, "take the scans of this sensor label");
            app.add_option("--max", flags->max, "take at most N scans of the input");
            app.add_option("--svg", flags->svg, "write the curves as a picture to this file");
            app.add_option("--threads", flags->threads, "threads (default: all cores); the result is the same");
            app.add_option("--plugin", flags->plugins, "load a library with recognisers, readers, … of your own")
                ->allow_extra_args(false);
            app.add_flag("--json", flags->json, "print one JSON object on stdout and nothing else");
            return [flags](const GlobalOptions& global) { return run(*flags, global); };
          }};
}

}  // namespace scslam::cli
