#include "scslam/apps/merge/merge.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <tuple>

#include "scslam/apps/alignment.h"
#include "scslam/apps/merge/merge_truth.h"
#include "scslam/apps/merge/write_merged.h"
#include "scslam/apps/partial_folder.h"
#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "scslam/core/peak_memory.h"
#include "scslam/core/progress.h"
#include "scslam/session/manifest.h"

namespace scslam {

void MergeParams::describe(ParamVisitor& v) {
  v.field("min_loops", min_loops, "loops that agree with each other before two sessions are joined", 2, 10000);
  v.field("min_spread_m", min_spread_m, "and the way they must be spread over [m]", 0, 1e5);
  v.field("enough_loops", enough_loops, "agreeing loops after which the search for a pair's placement ends", 2, 100000);
  v.field("max_trials", max_trials, "candidates of a pair registered in that search at most", 1, 10000000);
  v.field("rounds_in_vain", rounds_in_vain,
          "candidates of each stretch of way that may fail before the search for a pair without any loop ends", 1,
          10000);
  v.field("trial_spacing_m", trial_spacing_m, "one candidate of each such stretch of way is tried before others [m]",
          0.1, 1e5);
  v.field("radius_m", radius_m, "once placed, keyframes this near each other are candidates too [m]", 0, 1000);
  v.field("loop_distance_m", loop_distance_m, "but not nearer than this, along both ways, to a loop there is [m]", 0.1,
          1e5);
  v.field("max_loops", max_loops, "candidates of a pair registered in this second round at most", 0, 10000000);
  v.field("max_contradictions", max_contradictions,
          "share of them that may see through the other session's walls before the pair is taken apart", 0, 1);
  v.group("point_map", point_map, "how a point map (.ply, .pcd) is looked at");
}

namespace {

struct Input {
  Session session;
  std::filesystem::path truth;
  std::string digest;
  bool isPointMap() const { return session.info().input_format == kPointMap; }
};

/// A session and all that went into it.
std::vector<std::string> ancestry(const Input& input) {
  std::vector<std::string> digests = {input.digest};
  for (const SessionParent& parent : input.session.info().parents) {
    digests.push_back(parent.digest);
    digests.insert(digests.end(), parent.leaves.begin(), parent.leaves.end());
  }
  return digests;
}

void refuseRelatives(const std::vector<Input>& inputs) {
  std::map<std::string, const Input*> seen;
  for (const Input& input : inputs)
    for (const std::string& digest : ancestry(input)) {
      const auto [other, is_new] = seen.emplace(digest, &input);
      if (!is_new && other->second != &input)
        throw usageError(
            "{} and {} hold the same keyframes (given twice, a copy, or a merge beside one of its parents)",
            other->second->session.folder().string(), input.session.folder().string());
    }
}

/// Opened and put in an order of their own: point maps, whose frame is the result's, then by time, then by content.
std::vector<Input> openInputs(const MergeOptions& options, PointMapSessions& point_maps, const PluginContext& context) {
  if (options.sessions.size() < 2) throw usageError("merge needs two sessions or more");
  if (!options.truths.empty() && options.truths.size() != options.sessions.size())
    throw usageError("{} sessions but {} files with --gt: one for each session, in their order",
                     options.sessions.size(), options.truths.size());
  MergeConfig config;  // before the sessions' own: how point maps are looked at
  for (const auto& file : options.configs) loadConfig(config, file);
  for (const auto& assignment : options.sets) setParam(config, assignment);
  std::vector<Input> inputs;
  for (std::size_t i = 0; i < options.sessions.size(); ++i) {
    if (isPointMap(options.sessions[i]) && !options.truths.empty())
      throw usageError("{} is a point map and has no true trajectory: leave --gt out", options.sessions[i].string());
    Session session = Session::open(
        point_maps.sessionFor(options.sessions[i], config.merge.point_map, context, options.quiet, options.stop));
    std::string digest = contentDigest(session);
    inputs.push_back({std::move(session), options.truths.empty() ? "" : options.truths[i], std::move(digest)});
  }
  const auto key = [](const Input& input) {
    const auto& keyframes = input.session.keyframes();
    return std::tuple(!input.isPointMap(), keyframes.empty() ? Stamp{} : keyframes.front().stamp, input.digest);
  };
  std::stable_sort(inputs.begin(), inputs.end(), [&](const Input& p, const Input& q) { return key(p) < key(q); });
  refuseRelatives(inputs);
  return inputs;
}

/// Whose base frame and configuration the others take: the longest one that was recorded.
const Session& longestOf(const std::vector<Input>& inputs) {
  const auto length = [](const Input& input) {
    return std::pair(!input.isPointMap(), input.session.keyframes().size());
  };
  return std::max_element(inputs.begin(), inputs.end(),
                          [&](const Input& p, const Input& q) { return length(p) < length(q); })
      ->session;
}

MergeConfig resolveConfig(const MergeOptions& options, const Session& reference, const PluginContext& context) {
  MergeConfig config;
  if (reference.info().config_yaml.empty() && reference.info().planar) loadConfig(config.slam, "laser2d");
  loadSessionConfig(config.slam, reference, context);
  for (const auto& file : options.configs) loadConfig(config, file);
  for (const auto& assignment : options.sets) setParam(config, assignment);
  return config;
}

void checkAlike(const std::vector<SavedMap>& maps, const MergeParams& params, const PluginContext& context) {
  const SessionInfo& first = maps.front().session().info();
  const std::string first_folder = maps.front().origin().string();
  for (const SavedMap& map : maps) {
    const SessionInfo& info = map.session().info();
    const std::string folder = map.origin().string();
    if (map.keyframes().size() < static_cast<std::size_t>(params.min_loops))
      throw inputError("{} holds {} keyframe{} with a scan; merging needs {} loops that agree (merge.min_loops)",
                       folder, map.keyframes().size(), map.keyframes().size() == 1 ? "" : "s", params.min_loops);
    if (info.planar != first.planar)
      throw inputError("{} holds {} scans and {} {}: their places cannot be compared", folder,
                       info.planar ? "planar" : "3-D", first_folder, first.planar ? "planar ones" : "3-D ones");
    if (!map.session().complete()) logWarn(context.log, "{} was not completed; what it holds so far is merged", folder);
    if (map.keyframesWithoutScan() > 0)
      logWarn(context.log, "{}: {} of {} keyframes have no scan and are left out", folder, map.keyframesWithoutScan(),
              map.session().keyframes().size());
    if (info.sensor_table != first.sensor_table && !map.rigid() && !maps.front().rigid())
      logWarn(context.log, "{} and {} were made with different sensor tables ('{}', '{}')", first_folder, folder,
              first.sensor_table, info.sensor_table);
  }
}

std::vector<std::string> uniqueNames(const std::vector<SavedMap>& maps) {
  std::vector<std::string> names;
  for (const SavedMap& map : maps) {
    std::string name = map.name();
    for (int n = 2; std::find(names.begin(), names.end(), name) != names.end(); ++n)
      name = fmt::format("{}_{}", map.name(), n);
    names.push_back(name);
  }
  return names;
}

/// From candidates to one frame.
class Merger {
 public:
  Merger(const std::vector<SavedMap>& maps, const MergeConfig& config, const PluginContext& context,
         const Pose& T_base_sensor, const std::function<void()>& tick)
      : maps_(maps),
        config_(config),
        trial_(config.slam.registration, context, T_base_sensor.translation()),
        tick_(tick) {}

  void searchPairs(PlaceSearch& search) {
    for (std::size_t b = 0; b < maps_.size(); ++b)
      for (std::size_t a = 0; a < b; ++a) {
        SessionPair& pair = pairs_.emplace_back();
        pair.a = a, pair.b = b;
        pair.loops = std::make_unique<PairLoops>(maps_[a], maps_[b], config_.slam, config_.merge);
        pair.loops->tryFound(std::move(search.found[b][a]), trial_, tick_);
        pair.refusal = pair.loops->refusal();
      }
  }

  /// Solved, more loops tried where the sessions meet, solved again, until every pair that joins is still believed.
  /// Each repetition takes a pair apart or is the last.
  SessionUnion join() {
    std::set<const SessionPair*> densified;
    while (true) {
      const auto members = connectedSessions(maps_, pairs_).front();
      if (members.size() < 2) throw Error(ExitCode::kQualityGate, "no two of the sessions overlap: " + reasons());
      SessionUnion joined = solveUnion(maps_, pairs_, members, config_.slam);
      bool again = false;
      for (SessionPair& pair : pairs_) {
        if (joined.T_map_base[pair.a].empty() || joined.T_map_base[pair.b].empty()) continue;
        if (densified.insert(&pair).second) {
          pair.loops->tryNear(joined.T_map_base[pair.a], joined.T_map_base[pair.b], trial_, tick_);
          again = true;
        }
        const bool was_joined = pair.refusal.empty();
        if (was_joined || again) pair.refusal = pair.loops->refusal();
        again |= was_joined != pair.refusal.empty();
      }
      if (!again) return joined;
    }
  }
  std::vector<SessionPair>& pairs() { return pairs_; }

 private:
  std::string reasons() const {
    std::string text;
    for (const SessionPair& pair : pairs_)
      text += fmt::format("{}{} and {}: {}", text.empty() ? "" : "; ", maps_[pair.a].name(), maps_[pair.b].name(),
                          pair.refusal);
    return text;
  }

  const std::vector<SavedMap>& maps_;
  const MergeConfig& config_;
  LoopTrial trial_;
  std::function<void()> tick_;
  std::vector<SessionPair> pairs_;
};

MergeSummary summarise(const std::vector<SavedMap>& maps, const std::vector<std::string>& names,
                       const std::vector<SessionPair>& pairs, const SessionUnion& joined) {
  MergeSummary summary;
  const MemberPlaces places = placesOf(maps, joined);
  for (std::size_t s = 0; s < maps.size(); ++s) {
    MergedParent parent{maps[s].origin(), names[s], maps[s].keyframes().size(), maps[s].keyframesWithoutScan()};
    parent.joined = !joined.T_map_base[s].empty();
    if (parent.joined) {
      parent.first_keyframe = places.first_keyframe[s];
      parent.time_offset_s = std::chrono::duration<double>(places.time_offset[s]).count();
      parent.T_map_parent = alignPoses(joined.T_map_base[s], maps[s].poses());
      summary.keyframes += parent.keyframes, summary.scans += maps[s].scans().size();
      for (const LoopRecord& loop : joined.own_loops[s]) summary.loops += loop.accepted ? 1 : 0;
    }
    summary.parents.push_back(std::move(parent));
  }
  for (const SessionPair& pair : pairs) {
    MergedPair figures;
    figures.a = pair.a, figures.b = pair.b;
    figures.trials = pair.loops->records().size();
    figures.joined = pair.refusal.empty() && summary.parents[pair.a].joined;
    figures.loops = figures.joined ? pair.loops->accepted() : 0;
    figures.reason = pair.refusal;
    summary.loops += figures.loops;
    summary.pairs.push_back(std::move(figures));
  }
  return summary;
}

SessionInfo infoOf(SessionInfo info, const std::vector<SavedMap>& maps, const std::vector<std::string>& digests,
                   const std::vector<std::string>& names, const SessionUnion& joined, const MergeConfig& config) {
  info.parents.clear();
  info.input.clear();
  std::string all_digests;
  for (const std::size_t s : joined.members) {
    SessionParent parent{names[s], digests[s], {}};
    for (const SessionParent& earlier : maps[s].session().info().parents) {
      parent.leaves.push_back(earlier.digest);
      parent.leaves.insert(parent.leaves.end(), earlier.leaves.begin(), earlier.leaves.end());
    }
    info.parents.push_back(std::move(parent));
    info.input += (info.input.empty() ? "" : " + ") + names[s];
    all_digests += digests[s];
  }
  info.input_format = "merged sessions";
  info.input_digest = digestOf(all_digests);
  info.config_yaml = dumpYaml(config.slam);
  info.recogniser = fmt::format("{}", fmt::join(config.slam.place.recognisers.names, ", "));
  info.registration = config.slam.registration.method.name;
  return info;
}

/// A loop that was judged false by its pair counts for nothing in the result.
void dropLoopsOfRefusedPairs(std::vector<SessionPair>& pairs) {
  for (SessionPair& pair : pairs) {
    if (pair.refusal.empty()) continue;
    for (LoopRecord& record : pair.loops->records())
      if (record.accepted) record.accepted = false, record.reason = "its sessions are not joined: " + pair.refusal;
  }
}

}  // namespace

MergeSummary mergeSessions(const MergeOptions& options, const PluginContext& context) {
  const auto start = std::chrono::steady_clock::now();
  PartialFolder partial(options.output, options.sessions, sessionResult(), options.overwrite);
  PointMapSessions point_maps(options.output);
  std::vector<Input> inputs = openInputs(options, point_maps, context);
  const SessionInfo reference = longestOf(inputs).info();
  const MergeConfig config = resolveConfig(options, longestOf(inputs), context);
  const Pose T_base_sensor = reference.T_base_sensor;
  const auto cache_bytes = static_cast<std::size_t>(config.slam.session.cloud_cache_mb * 1e6);  // of each session

  std::vector<SavedMap> maps;
  std::vector<Trajectory> truths;
  std::vector<std::string> digests;
  std::size_t keyframes = 0;
  for (Input& input : inputs) {
    if (!input.truth.empty()) truths.push_back(readTrajectory(input.truth));
    digests.push_back(input.digest);
    maps.emplace_back(std::move(input.session), T_base_sensor, config.slam.registration, cache_bytes);
    keyframes += maps.back().keyframes().size();
  }
  checkAlike(maps, config.merge, context);
  const std::vector<std::string> names = uniqueNames(maps);

  const auto tick = [&options] {
    if (options.stop != nullptr && *options.stop) throw Error(ExitCode::kStopped, "stopped; nothing was written");
  };
  Progress reading("places", keyframes, options.quiet);
  PlaceSearch search = searchPlaces(maps, config.slam.place, context, [&](std::size_t done) {
    tick();
    reading.update(done);
  });
  reading.finish();
  std::size_t trials = 0;
  Progress trying("candidates", std::nullopt, options.quiet);
  Merger merger(maps, config, context, T_base_sensor, [&] {
    tick();
    trying.update(++trials);
  });
  merger.searchPairs(search);
  const SessionUnion joined = merger.join();
  trying.finish();
  dropLoopsOfRefusedPairs(merger.pairs());

  MergeSummary summary = summarise(maps, names, merger.pairs(), joined);
  if (!truths.empty()) judgeMerge(maps, merger.pairs(), joined, truths, summary);
  std::size_t written = 0;
  Progress writing("writing", summary.keyframes, options.quiet);
  const auto metrics = [&] {
    summary.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    summary.peak_rss_mb = peakRssMb();
    return mergeJson(summary);
  };
  writeMerged(partial.folder(), infoOf(reference, maps, digests, names, joined, config), maps, names, merger.pairs(),
              joined, search.descriptors, metrics, [&] {
                tick();
                writing.update(++written);
              });
  writing.finish();
  partial.replaceTarget();
  return summary;
}

}  // namespace scslam
