#include "scslam/apps/localize/localize.h"

#include <algorithm>
#include <chrono>

#include "scslam/apps/localize/localize_truth.h"
#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/log.h"
#include "scslam/core/progress.h"
#include "scslam/pipeline/prefetch.h"
#include "scslam/sensor/sensor_tables.h"

namespace scslam {
namespace {

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::string csvRow(const Scan& scan, const Whereabouts& where) {
  std::string row = fmt::format("{},{},{}", scan.index, formatStamp(scan.stamp), nameOf(where.state));
  if (where.state == WhereState::kSearching) {
    row += std::string(7 + 21 + 1, ',');
  } else {
    Eigen::Quaterniond q(where.T_map_base.linear());
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    const auto& t = where.T_map_base.translation();
    row += fmt::format(",{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g}", t.x(), t.y(), t.z(), q.x(), q.y(), q.z(),
                       q.w());
    for (int i = 0; i < 6; ++i)
      for (int j = i; j < 6; ++j) row += fmt::format(",{:.6g}", where.covariance(i, j));
    row += where.keyframe ? fmt::format(",{}", *where.keyframe) : ",";
  }
  std::string note = where.note;
  std::replace(note.begin(), note.end(), '"', '\'');
  return row + (note.empty() ? ",\n" : ",\"" + note + "\"\n");
}

std::string csvHeader() {
  std::string header = "scan,time_s,state,tx,ty,tz,qx,qy,qz,qw";
  for (int i = 0; i < 6; ++i)
    for (int j = i; j < 6; ++j) header += fmt::format(",c{}{}", i, j);
  return header + ",keyframe,note\n";
}

/// Everything that happens to one scan.
class Drive {
 public:
  Drive(const SavedMap& map, const LocalizeConfig& config, const PluginContext& context, ScanSource& source)
      : config_(config),
        context_(context),
        source_(source),
        localiser_(map, config.slam, config.localize, context),
        T_base_sensor_(map.session().info().T_base_sensor),
        radar_points_(config.slam.radar, context) {
    beginOdometry();
  }

  void process(Scan scan) {
    ++summary.scans;
    if (!begin_) begin_ = scan.stamp;
    std::string note;
    if (scan.radar) scan.cloud = radar_points_(*scan.radar, note);
    preprocess(scan, config_.slam.preprocess);
    OdometryStep step = odometry_->step(scan);
    // From the input's own base frame to the one in which the sensor sits where the session's sat.
    const Pose T_own_base = scan.T_base_sensor * T_base_sensor_.inverse();
    step.T_odom_base = step.T_odom_base * T_own_base;
    transformInPlace(step.cloud, T_own_base.inverse());
    const Matrix6d J = adjoint(Pose(T_own_base.inverse()));
    step.covariance = J * step.covariance * J.transpose();

    const bool was_searching = localiser_.searching();
    const auto start = Clock::now();
    Whereabouts where = localiser_.step(step);
    (was_searching ? search_ms : track_ms).push_back(millisecondsSince(start));
    if (!step.quality.ok)
      where.note += fmt::format("{}odometry: {}", where.note.empty() ? "" : "; ", step.quality.note);
    count(scan, where, was_searching);
    unusable_ = step.quality.ok || where.state == WhereState::kTracking ? 0 : unusable_ + 1;
    if (where.odometry_doubted || unusable_ >= config_.localize.restart_after_scans) restart(scan, T_own_base);

    const Matrix6d K = adjoint(T_own_base);
    where.T_map_base = where.T_map_base * T_own_base.inverse();
    where.covariance = K * where.covariance * K.transpose();
    csv += csvRow(scan, where);
    if (where.state == WhereState::kTracking)
      tracked.push_back({scan.stamp, scan.index, where.T_map_base, *where.keyframe});
  }

  LocalizeSummary summary;
  std::string csv = csvHeader();
  std::vector<TrackedScan> tracked;
  std::vector<double> search_ms, track_ms;

 private:
  void beginOdometry() {
    odometry_ = config_.slam.odometry.frontend.create(context_);
    odometry_->begin(source_.size(), source_.T_base_reference());
    unusable_ = 0;
  }
  /// Odometry anew, from this scan on.
  void restart(const Scan& scan, const Pose& T_own_base) {
    beginOdometry();
    localiser_.odometryRestarted(odometry_->step(scan).T_odom_base * T_own_base);
    ++summary.restarts;
  }
  void count(const Scan& scan, const Whereabouts& where, bool was_searching) {
    summary.tracked += where.state == WhereState::kTracking;
    summary.coasted += where.state == WhereState::kCoasting;
    summary.losses += !was_searching && where.state == WhereState::kSearching;
    if (!where.first_fix) return;
    ++summary.fixes;
    if (summary.first_fix_scan) return;
    summary.first_fix_scan = summary.scans - 1;
    summary.first_fix_s = secondsBetween(*begin_, scan.stamp);
  }

  const LocalizeConfig& config_;
  const PluginContext& context_;
  ScanSource& source_;
  Localiser localiser_;
  Pose T_base_sensor_;
  RadarPoints radar_points_;
  std::unique_ptr<Odometry> odometry_;
  int unusable_ = 0;
  std::optional<Stamp> begin_;
};

LocalizeConfig resolveConfig(const LocalizeOptions& options, const Session& session, const PluginContext& context) {
  LocalizeConfig config;
  if (session.info().config_yaml.empty() && session.info().planar) loadConfig(config.slam, "laser2d");
  loadSessionConfig(config.slam, session, context);
  if (config.slam.odometry.frontend.name == "poses")
    config.slam.odometry.frontend.name = OdometryParams().frontend.name;
  for (const auto& file : options.configs) loadConfig(config, file);
  for (const auto& assignment : options.sets) setParam(config, assignment);
  return config;
}

void take(Drive& drive, ScanSource& source, Scan first, const LocalizeOptions& options) {
  std::optional<std::size_t> total = source.size();
  if (total) total = *total - std::min(*total, options.skip);
  if (options.max) total = total ? std::min(*total, *options.max) : *options.max;
  Progress progress("localising", total, options.quiet);
  std::optional<Scan> scan = std::move(first);
  std::optional<Stamp> last;
  Prefetcher ahead(source);
  while (scan && (!options.max || drive.summary.scans < *options.max)) {
    if (options.stop != nullptr && *options.stop) {
      drive.summary.stopped = true;
      break;
    }
    if (!last || scan->stamp > *last) {
      last = scan->stamp;
      drive.process(std::move(*scan));
    }
    progress.update(drive.summary.scans);
    try {
      scan = ahead.next();
    } catch (const Error& error) {
      if (error.code() != ExitCode::kInput) throw;
      drive.summary.ended_early = error.what();
      break;
    }
  }
  progress.finish();
}

}  // namespace

LocalizeSummary localize(const LocalizeOptions& options, const PluginContext& context) {
  const auto start = Clock::now();
  LocalizeConfig given;  // before the session's own: how a point map is looked at
  for (const auto& file : options.configs) loadConfig(given, file);
  for (const auto& assignment : options.sets) setParam(given, assignment);
  PointMapSessions point_maps(options.output);
  Session session =
      Session::open(point_maps.sessionFor(options.session, given.point_map, context, options.quiet, options.stop));
  const LocalizeConfig config = resolveConfig(options, session, context);
  OpenOptions open;
  open.label = options.label;
  open.radar = config.slam.radar.prefer;
  if (!options.sensor.empty()) open.sensor = loadSensorModel(options.sensor);
  const OpenedSource opened = openSource(options.input, context, open);
  logInfo(context.log, "input: {} ({}): {}", opened.format, opened.why, opened.source->description());
  if (options.skip > 0) opened.source->skip(options.skip);
  std::optional<Scan> first = opened.source->next();
  if (!first) throw inputError("{} holds no scans{}", options.input, options.skip > 0 ? " after those skipped" : "");
  if (first->planar != session.info().planar)
    throw inputError("{} holds {} scans, the session {}: they cannot be compared", options.input,
                     first->planar ? "planar" : "3-D", session.info().planar ? "planar ones" : "3-D ones");

  const Pose T_base_sensor = session.info().T_base_sensor;
  const SavedMap map(std::move(session), T_base_sensor, config.slam.registration,
                     static_cast<std::size_t>(config.slam.session.cloud_cache_mb * 1e6));
  if (map.keyframesWithoutScan() > 0)
    logWarn(context.log, "{} of {} keyframes of the session have no scan; nothing is found there",
            map.keyframesWithoutScan(), map.session().keyframes().size());
  Drive drive(map, config, context, *opened.source);
  take(drive, *opened.source, std::move(*first), options);

  LocalizeSummary& summary = drive.summary;
  if (!options.truth.empty()) summary.error = localizeError(drive.tracked, map, options.truth, options.session_truth);
  summary.search_ms_median = median(drive.search_ms), summary.track_ms_median = median(drive.track_ms);
  summary.wall_s = millisecondsSince(start) / 1000;
  std::vector<StampedPose> poses;
  for (const TrackedScan& scan : drive.tracked) poses.push_back({scan.stamp, scan.T_map_base});
  writeFileAtomically(options.output.string() + ".tum", formatTum(poses));
  writeFileAtomically(options.output.string() + ".csv", drive.csv);
  return summary;
}

}  // namespace scslam
