#include "scslam/apps/run_job.h"

#include <dlfcn.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "scslam/apps/input_digest.h"
#include "scslam/apps/motion_scale.h"
#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "scslam/core/peak_memory.h"
#include "scslam/core/progress.h"
#include "scslam/pipeline/prefetch.h"
#include "scslam/sensor/sensor_tables.h"

namespace scslam {
namespace {

/// Defaults, then the profile that fits the data, then files, then --set.
SlamParams resolveParams(const RunOptions& options, const char* profile) {
  SlamParams params;
  if (profile != nullptr) loadConfig(params, profile);
  for (const auto& config : options.configs) loadConfig(params, config);
  for (const auto& assignment : options.sets) setParam(params, assignment);
  return params;
}

/// The shipped configuration that fits the scans, nullptr for the defaults.
const char* profileOf(const Scan& scan, mrpt::system::COutputLogger& log) {
  if (!scan.planar) return nullptr;
  const char* profile = scan.radar ? "radar" : "laser2d";
  logInfo(log, "configuration: {} (the scans are {})", profile, scan.radar ? "of a radar" : "planar");
  return profile;
}

SessionInfo describeSession(const RunOptions& options, const std::string& format, const SlamParams& params,
                            const Scan& first) {
  SessionInfo info;
  info.input = options.input;
  info.input_format = format;
  info.input_digest = inputDigest(options.input, options.skip);
  info.config_yaml = dumpYaml(params);
  info.odometry = params.odometry.frontend.name;
  info.recogniser = fmt::format("{}", fmt::join(params.place.recognisers.names, ", "));
  info.registration = params.registration.method.name;
  info.sensor_label = first.label;
  info.sensor_table = options.sensor;
  info.T_base_sensor = first.T_base_sensor;
  info.planar = first.planar;
  return info;
}

double percentile(std::vector<float> values, double share) {
  if (values.empty()) return 0;
  const auto k = static_cast<std::size_t>(std::lround(share * static_cast<double>(values.size() - 1)));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(k), values.end());
  return values[k];
}

std::string metricsJson(const RunSummary& s, int threads) {
  nlohmann::ordered_json json = {{"scans", s.counts.scans},
                                 {"keyframes", s.counts.keyframes},
                                 {"loop_candidates", s.counts.candidates},
                                 {"loops_accepted", s.counts.loops},
                                 {"empty_scans", s.counts.empty_scans},
                                 {"late_scans", s.counts.late_scans},
                                 {"lost_scans", s.counts.lost_scans},
                                 {"input_duration_s", s.input_duration_s},
                                 {"wall_s", s.wall_s},
                                 {"realtime_factor", s.wall_s > 0 ? s.input_duration_s / s.wall_s : 0},
                                 {"ms_per_scan", {{"median", s.ms_per_scan_median}, {"p95", s.ms_per_scan_p95}}}};
  for (std::size_t i = 0; i < kStageNames.size(); ++i) json["stages_ms"][kStageNames[i]] = s.times.total_ms[i];
  json["peak_rss_mb"] = s.peak_rss_mb;
  json["threads"] = threads;
  json["ended"] = s.end == SessionEnd::kDone ? "done" : s.end == SessionEnd::kStopped ? "stopped" : "input ended early";
  return json.dump(2) + "\n";
}

/// Watches the scale of a radar's motion (motion_scale.h).
class ScaleWatch {
 public:
  void add(const Scan& scan) {
    if (!scan.radar) return;
    resolution_m_ = scan.radar->range_resolution_m;
    reference_.add(scan);
  }
  /// The complaint, empty when all is well or nothing can be said. @param session that was finished.
  std::string verdict(const std::filesystem::path& session, const std::optional<Trajectory>& truth) const {
    std::string source;
    const auto reference = resolution_m_ > 0 ? reference_.trajectory(truth, source) : std::nullopt;
    if (!reference) return "";
    const auto scale = motionScale(readTrajectory(session / "odometry.tum"), *reference);
    return scale ? scaleComplaint(*scale, resolution_m_, source) : "";
  }

 private:
  double resolution_m_ = 0;
  MotionReference reference_;
};

/// Runs scans through the pipeline until the source, the user or damage ends it.
void drive(Slam& slam, ScanSource& source, std::optional<Scan> first, std::size_t taken, const RunOptions& options,
           RunSummary& summary, ScaleWatch& scale) {
  std::optional<std::size_t> total = source.size();
  if (total) total = *total - std::min(*total, options.skip);
  if (options.max) total = total ? std::min(*total, *options.max) : *options.max;
  Progress progress("mapping", total, options.quiet);
  std::optional<Stamp> begin, end;
  try {
    std::optional<Prefetcher> ahead;
    while (!options.max || taken < *options.max) {
      if (options.stop != nullptr && *options.stop) {
        summary.end = SessionEnd::kStopped;
        break;
      }
      if (!first) {
        if (!ahead) ahead.emplace(source);
        first = ahead->next();
        if (!first) break;
      }
      if (!begin) begin = first->stamp;
      end = first->stamp;
      scale.add(*first);
      slam.process(std::move(*first));
      first.reset();
      progress.update(++taken);
    }
  } catch (const Error& error) {
    if (error.code() != ExitCode::kInput || slam.counts().scans == 0) throw;
    summary.end = SessionEnd::kEndedEarly;
    summary.end_reason = error.what();
  }
  if (begin) summary.input_duration_s = secondsBetween(*begin, *end);
}

/// The loops that only the corrected map shows. Where the user stops this, a resumed run does it from its beginning.
void lookAgain(Slam& slam, const RunOptions& options, RunSummary& summary) {
  std::optional<Progress> progress;
  slam.lookAgain([&](std::size_t done, std::size_t total) {
    if (!progress) progress.emplace("looking for loops again", total, options.quiet);
    if (options.stop != nullptr && *options.stop) summary.end = SessionEnd::kStopped;
    progress->update(done);
    return summary.end != SessionEnd::kStopped;
  });
}

}  // namespace

void loadPlugin(const std::string& library) {
  if (dlopen(library.c_str(), RTLD_NOW | RTLD_GLOBAL) == nullptr)
    throw usageError("--plugin {}: {}", library, dlerror());
}

RunSummary runJob(const RunOptions& options, const PluginContext& context) {
  OpenOptions open;
  open.label = options.label;
  open.radar = resolveParams(options, nullptr).radar.prefer;
  if (!options.sensor.empty()) open.sensor = loadSensorModel(options.sensor);
  const OpenedSource opened = openSource(options.input, context, open);
  logInfo(context.log, "input: {} ({}): {}", opened.format, opened.why, opened.source->description());
  return runJob(options, context, *opened.source, opened.format);
}

RunSummary runJob(const RunOptions& options, const PluginContext& context, ScanSource& source,
                  const std::string& format) {
  const auto start = std::chrono::steady_clock::now();
  if (options.skip > 0) source.skip(options.skip);
  std::optional<Scan> first = source.next();
  if (!first) throw inputError("{} holds no scans{}", options.input, options.skip > 0 ? " after those skipped" : "");
  const SlamParams params = resolveParams(options, profileOf(*first, context.log));

  const SessionInfo info = describeSession(options, format, params, *first);
  RecoveredSession recovered;
  const auto session = options.resume ? SessionWriter::resume(options.output, info, recovered)
                                      : SessionWriter::create(options.output, info, options.overwrite);
  Slam slam(params, context, *session, info.T_base_sensor);
  std::optional<std::size_t> count = source.size();
  if (count) count = *count - std::min(*count, options.skip);
  slam.begin(count, source.T_base_reference());
  const std::size_t taken = slam.resume(std::move(recovered));
  if (taken > 0) {
    logInfo(context.log, "going on after scan {} ({} keyframes)", taken, slam.counts().keyframes);
    source.skip(taken - 1);
    first.reset();
  }

  RunSummary summary;
  ScaleWatch scale;
  drive(slam, source, std::move(first), taken, options, summary, scale);
  slam.checkpoint();
  if (summary.end != SessionEnd::kStopped) lookAgain(slam, options, summary);
  slam.finish(summary.end);
  summary.counts = slam.counts();
  summary.times = slam.times();
  summary.session = options.output;
  summary.ground_truth = source.groundTruth();
  summary.T_base_reference = source.T_base_reference();
  if (params.odometry.frontend.name != "poses" && summary.counts.scans > 0)
    summary.warning = scale.verdict(options.output, summary.ground_truth);
  if (!summary.warning.empty()) logWarn(context.log, "{}", summary.warning);
  summary.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  summary.peak_rss_mb = peakRssMb();
  summary.ms_per_scan_median = percentile(summary.times.scan_ms, 0.5);
  summary.ms_per_scan_p95 = percentile(summary.times.scan_ms, 0.95);
  summary.metrics_json = metricsJson(summary, context.threads.size());
  session->writeMetrics(summary.metrics_json);
  if (options.add) options.add(summary);
  if (summary.end != SessionEnd::kStopped) session->seal();
  return summary;
}

}  // namespace scslam
