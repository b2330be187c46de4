#include "scslam/apps/localize/localize.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "scslam/apps/alignment.h"
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

/// T_truth_map from the session's own truth.
Pose placeInTruth(const Session& session, const std::filesystem::path& file) {
  const Trajectory truth = readTrajectory(file);
  if (!truth.timed && truth.poses.size() != session.scans().size())
    throw inputError("{} has {} poses and no times, the session has {} scans", file.string(), truth.poses.size(),
                     session.scans().size());
  std::vector<Pose> in_truth, in_map;
  for (const Keyframe& keyframe : session.keyframes()) {
    const std::size_t row = keyframe.scan_index - session.scans().front().index;
    const auto T = truth.timed                ? truth.at(keyframe.stamp)
                   : row < truth.poses.size() ? std::optional(truth.poses[row].T)
                                              : std::nullopt;
    if (T) in_truth.push_back(*T), in_map.push_back(session.poses()[keyframe.id]);
  }
  if (in_truth.empty()) throw inputError("{} has no pose at the time of any keyframe of the session", file.string());
  return alignPoses(in_truth, in_map);
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
    count(scan, where, was_searching);
    if (!step.quality.ok && localiser_.searching() && ++unusable_ >= config_.localize.restart_after_scans) restart();
    if (step.quality.ok) unusable_ = 0;

    const Matrix6d K = adjoint(T_own_base);
    where.T_map_base = where.T_map_base * T_own_base.inverse();
    where.covariance = K * where.covariance * K.transpose();
    csv += csvRow(scan, where);
    if (where.state == WhereState::kTracking)
      poses.push_back({scan.stamp, where.T_map_base}), rows.push_back(scan.index);
  }

  LocalizeSummary summary;
  std::string csv = csvHeader();
  std::vector<StampedPose> poses;
  std::vector<std::size_t> rows;  ///< scan of each pose
  std::vector<double> search_ms, track_ms;

 private:
  void beginOdometry() {
    odometry_ = config_.slam.odometry.frontend.create(context_);
    odometry_->begin(source_.size(), source_.T_base_reference());
    unusable_ = 0;
  }
  void restart() {
    beginOdometry();
    localiser_.odometryRestarted();
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

LocalizeError errorOf(const Drive& drive, const Session& session, const LocalizeOptions& options) {
  const Trajectory truth = readTrajectory(options.truth);
  std::vector<Pose> in_truth, in_map;
  for (std::size_t i = 0; i < drive.poses.size(); ++i) {
    const auto T = truth.timed                          ? truth.at(drive.poses[i].stamp)
                   : drive.rows[i] < truth.poses.size() ? std::optional(truth.poses[drive.rows[i]].T)
                                                        : std::nullopt;
    if (T) in_truth.push_back(*T), in_map.push_back(drive.poses[i].T);
  }
  LocalizeError error;
  error.poses = in_truth.size();
  const bool placed = !options.session_truth.empty();
  error.alignment = placed ? "the session's truth places the map" : "truth laid on the result (give --session-gt)";
  const Pose T_truth_map = placed ? placeInTruth(session, options.session_truth) : alignPoses(in_truth, in_map);
  std::vector<double> metres;
  double square_m2 = 0, square_rad2 = 0;
  for (std::size_t i = 0; i < in_truth.size(); ++i) {
    const Vector6d d = local(in_truth[i], T_truth_map * in_map[i]);
    const double m = d.head<3>().norm(), rad = d.tail<3>().norm();
    metres.push_back(m);
    square_m2 += m * m, square_rad2 += rad * rad;
    error.max_m = std::max(error.max_m, m);
    error.wrong += m > 1 || rad > 5 * M_PI / 180;
  }
  const auto n = static_cast<double>(std::max<std::size_t>(1, in_truth.size()));
  error.rmse_m = std::sqrt(square_m2 / n), error.rmse_deg = std::sqrt(square_rad2 / n) * 180 / M_PI;
  error.median_m = median(metres);
  return error;
}

LocalizeConfig resolveConfig(const LocalizeOptions& options, const Session& session, const PluginContext& context) {
  LocalizeConfig config;
  if (session.info().config_yaml.empty() && session.info().planar) loadConfig(config.slam, "laser2d");
  loadSessionConfig(config.slam, session, context);
  if (config.slam.odometry.frontend.name == "poses")
    config.slam.odometry.frontend.name = OdometryParams().frontend.name;
  for (const auto& file : options.configs) loadConfig(config.slam, file);
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
  Session session = Session::open(options.session);
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
  const SavedMap map(std::move(session), T_base_sensor, config.slam.registration.voxel_m,
                     static_cast<std::size_t>(config.slam.session.cloud_cache_mb * 1e6));
  if (map.keyframesWithoutScan() > 0)
    logWarn(context.log, "{} of {} keyframes of the session have no scan; nothing is found there",
            map.keyframesWithoutScan(), map.session().keyframes().size());
  Drive drive(map, config, context, *opened.source);
  take(drive, *opened.source, std::move(*first), options);

  LocalizeSummary& summary = drive.summary;
  if (!options.truth.empty()) summary.error = errorOf(drive, map.session(), options);
  summary.search_ms_median = median(drive.search_ms), summary.track_ms_median = median(drive.track_ms);
  summary.wall_s = millisecondsSince(start) / 1000;
  writeFileAtomically(options.output.string() + ".tum", formatTum(drive.poses));
  writeFileAtomically(options.output.string() + ".csv", drive.csv);
  return summary;
}

}  // namespace scslam
