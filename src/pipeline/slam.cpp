#include "scslam/pipeline/slam.h"

#include "scslam/core/log.h"
#include "scslam/pipeline/factors.h"

namespace scslam {

Slam::Slam(const SlamParams& params, const PluginContext& context, SessionWriter& session, const Pose& T_base_sensor)
    : params_(params),
      context_(context),
      session_(session),
      radar_points_(params.radar, context),
      odometry_(params.odometry.frontend.create(context)),
      selector_(params.keyframe),
      loops_(params, context, T_base_sensor),
      ledger_(params.graph),
      optimiser_(params.graph.optimiser),
      satellites_(params.graph.gnss),
      clouds_(session.folder(), static_cast<std::size_t>(params.session.cloud_cache_mb * 1e6),
              [T_base_sensor, registration = params.registration](const Cloud& cloud_sensor) {
                return transformed(loopScan(cloud_sensor, registration), T_base_sensor);
              }),
      T_base_sensor_(T_base_sensor) {}

void Slam::begin(std::optional<std::size_t> scan_count, const Pose& T_base_reference) {
  odometry_->begin(scan_count, T_base_reference);
}

void Slam::process(Scan scan) {
  ++taken_;
  if (!inOrder(scan)) return;
  const auto start = std::chrono::steady_clock::now();
  {
    const StageTimer timer(times_, Stage::kPreprocess);
    if (scan.radar) takePoints(scan);
    preprocess(scan, params_.preprocess);
  }
  OdometryStep step;
  {
    const StageTimer timer(times_, Stage::kOdometry);
    step = odometry_->step(scan);
  }
  ++counts_.scans;
  counts_.empty_scans += scan.cloud.empty();
  if (!step.quality.ok)
    ++counts_.lost_scans, say(fmt::format("scan {}: odometry lost: {}", scan.index, step.quality.note));
  const bool due = selector_.isDue(step.T_odom_base, step.covariance) && !step.cloud.empty();
  if (due) addKeyframe(scan, step);
  session_.addScan({scan.index, scan.stamp, step.T_odom_base, static_cast<std::int64_t>(keyframes_.size()) - 1});
  collectFixes(scan, step);
  if (due) closeLoops();
  if (due && keyframes_.size() % static_cast<std::size_t>(params_.session.checkpoint_every) == 0) checkpoint();
  times_.scan_ms.push_back(std::chrono::duration<float, std::milli>(std::chrono::steady_clock::now() - start).count());
}

bool Slam::inOrder(const Scan& scan) {
  if (last_stamp_ && scan.stamp <= *last_stamp_) {
    ++counts_.late_scans;
    say(fmt::format("scan {}: its time {} does not come after that of the scan before ({}): left out", scan.index,
                    formatStamp(scan.stamp), formatStamp(*last_stamp_)));
    return false;
  }
  last_stamp_ = scan.stamp;
  return true;
}

void Slam::takePoints(Scan& sweep) {
  std::string note;
  sweep.cloud = radar_points_(*sweep.radar, note);
  if (!note.empty()) say(fmt::format("scan {}: {}", sweep.index, note));
}

void Slam::addKeyframe(const Scan& scan, const OdometryStep& step) {
  Keyframe keyframe;
  keyframe.id = static_cast<KeyframeId>(keyframes_.size());
  keyframe.scan_index = scan.index;
  keyframe.stamp = scan.stamp;
  keyframe.planar = scan.planar;
  selector_.accept(keyframe);
  keyframe.step_passing = step.passing;

  const Pose T_map_base = appendNode(graph_, keyframes_, keyframe, params_.graph);
  keyframes_.push_back(keyframe);
  ledger_.addNode(keyframe);
  ++counts_.keyframes;
  Descriptor descriptor;
  {
    const StageTimer timer(times_, Stage::kPlace);
    descriptor = loops_.describe(keyframe, step.cloud);
  }
  {
    const StageTimer timer(times_, Stage::kSession);
    session_.addKeyframe(keyframe, T_map_base, transformed(step.cloud, T_base_sensor_.inverse()), descriptor);
  }
  const StageTimer timer(times_, Stage::kPlace);
  loops_.add(keyframe, descriptor, clouds_);
}

void Slam::closeLoops() {
  const bool accepted = closeLoops(keyframes_.back().id);
  if (accepted || satellites_.due()) solveOnline();
  counts_.candidates = ledger_.candidates(), counts_.loops = ledger_.accepted();
}

bool Slam::closeLoops(KeyframeId query) {
  std::vector<LoopRecord> records;
  {
    const StageTimer timer(times_, Stage::kRegistration);
    records = loops_.close(query, keyframes_, graph_.poses, clouds_);
  }
  bool accepted = false;
  for (LoopRecord& record : records) {
    ledger_.add(record);
    accepted |= record.accepted;
    session_.addLoop(record);
    say(fmt::format("loop {} -> {}: {}", record.query, record.match, record.reason));
  }
  return accepted;
}

void Slam::lookAgain(const std::function<bool(std::size_t, std::size_t)>& go_on) {
  if (!params_.place.look_again || ledger_.accepted() == 0) return;  // without a loop, no pose was corrected
  std::vector<KeyframeId> open;
  for (const Keyframe& keyframe : keyframes_)
    if (!ledger_.hasAccepted(keyframe.id)) open.push_back(keyframe.id);
  for (std::size_t k = 0; k < open.size() && go_on(k, open.size()); ++k) closeLoops(open[k]);
  counts_.candidates = ledger_.candidates(), counts_.loops = ledger_.accepted();
}

void Slam::collectFixes(const Scan& scan, const OdometryStep& step) {
  for (const GnssRecord& record :
       satellites_.take(scan, step.T_odom_base, keyframes_.empty() ? nullptr : &keyframes_.back())) {
    satellites_.add(record);
    session_.addGnss(record);
  }
}

/// What the new loops and fixes touch, from where the last solution stands: the scans do not wait for more.
void Slam::solveOnline() {
  const StageTimer timer(times_, Stage::kGraph);
  const std::size_t nodes = graph_.poses.size(), factors = graph_.factors.size();
  ledger_.appendTo(graph_);
  satellites_.appendTo(graph_);
  const IncrementalSummary summary = optimiser_.solve(graph_);
  graph_.poses.resize(nodes);
  graph_.factors.resize(factors);
  takeSolution(summary.rejected_edges);
  odometry_->correct(graph_.poses.back() * keyframes_.back().T_odom_base.inverse());
}

/// All poses and loops at once, at the end.
void Slam::solveAll() {
  const StageTimer timer(times_, Stage::kGraph);
  PoseGraph graph = graph_;
  ledger_.appendTo(graph);
  satellites_.appendTo(graph);
  const OptimiserSummary summary = optimise(graph, params_.graph.optimiser);
  std::copy_n(graph.poses.begin(), graph_.poses.size(), graph_.poses.begin());
  takeSolution(summary.rejected_edges);
}

void Slam::takeSolution(const std::vector<std::uint32_t>& rejected_edges) {
  ledger_.note(rejected_edges);
  for (const LoopVerdict& verdict : ledger_.judge()) {
    session_.judgeLoop(verdict);
    say(fmt::format("loop candidate {}: {}", verdict.loop, verdict.reason));
  }
  session_.setPoses(graph_.poses);
}

void Slam::checkpoint() {
  const StageTimer timer(times_, Stage::kSession);
  ByteWriter state;
  state.put(std::uint64_t{taken_});
  state.put(std::int64_t{last_stamp_ ? last_stamp_->time_since_epoch().count() : 0});
  state.put(std::vector<std::uint64_t>{counts_.scans, counts_.candidates, counts_.loops, counts_.empty_scans,
                                       counts_.late_scans, counts_.lost_scans});
  selector_.save(state);
  odometry_->save(state);
  satellites_.save(state);
  session_.checkpoint(state.bytes());
}

std::size_t Slam::resume(RecoveredSession recovered) {
  if (recovered.pipeline_state.empty()) return 0;
  ByteReader state(recovered.pipeline_state);
  taken_ = state.get<std::uint64_t>();
  last_stamp_ = Stamp(Stamp::duration(state.get<std::int64_t>()));
  std::vector<std::uint64_t> counts;
  state.get(counts);
  counts_ = {counts.at(0), recovered.keyframes.size(), counts.at(1), counts.at(2), counts.at(3), counts.at(4),
             counts.at(5)};
  selector_.load(state);
  odometry_->load(state);
  satellites_.load(state);
  for (const GnssRecord& record : recovered.gnss) satellites_.add(record);
  for (std::size_t k = 0; k < recovered.keyframes.size(); ++k) {
    appendNode(graph_, keyframes_, recovered.keyframes[k], params_.graph);
    keyframes_.push_back(recovered.keyframes[k]);
    ledger_.addNode(recovered.keyframes[k]);
    loops_.add(recovered.keyframes[k], recovered.descriptors[k], clouds_);
  }
  for (const LoopRecord& record : recovered.loops) ledger_.restore(record), loops_.restore(record);
  graph_.poses = std::move(recovered.T_map_base);
  return taken_;
}

void Slam::finish(SessionEnd end) {
  const bool any = ledger_.accepted() > 0 || satellites_.anyNew();
  if (end != SessionEnd::kStopped && any) solveAll();  // a stopped run goes on from the online solution
  counts_.loops = ledger_.accepted();
  const StageTimer timer(times_, Stage::kSession);
  session_.finish(graph());
}

PoseGraph Slam::graph() const {
  PoseGraph graph = graph_;
  ledger_.appendAcceptedTo(graph);
  return graph;
}

void Slam::say(const std::string& line) {
  session_.logLine(line);
  logDebug(context_.log, "{}", line);
}

}  // namespace scslam
