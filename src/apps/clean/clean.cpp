#include "scslam/apps/clean/clean.h"

#include <chrono>
#include <numeric>
#include <set>

#include "scslam/apps/clean/clean_score.h"
#include "scslam/apps/clean/scan_judge.h"
#include "scslam/apps/clean/views.h"
#include "scslam/apps/clean/write_clean.h"
#include "scslam/apps/partial_folder.h"
#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "scslam/core/peak_memory.h"
#include "scslam/core/progress.h"
#include "scslam/mapping/map_builder.h"

namespace scslam {
namespace fs = std::filesystem;

void CleanParams::describe(ParamVisitor& v) {
  v.field("soon_views", soon_views, "scans just before and after that a scan is held against", 2, 120);
  v.field("later_views", later_views, "and others at most, evenly spread over the time", 0, 120);
  v.field("reach_m", reach_m, "how far from it they may have been taken [m]", 0, 1e4);
  v.field("margin_m", margin_m, "a point this much nearer than all that a scan saw there was looked through [m]", 0.01,
          10);
  v.field("margin_per_m", margin_per_m, "and this much more for each metre of its range", 0, 1);
  v.field("sky_m", sky_m, "up to this range beams without any return looked through; 0: they say nothing [m]", 0, 1e4);
  v.field("min_free", min_free, "scans that must have looked through a point", 1, 255);
  v.field("sure_free", sure_free, "what so many looked through and none saw goes, whatever is around it", 1, 255);
  v.field("free_share", free_share, "and their share among all that saw its place", 0, 1);
  v.field("object_height_m", object_height_m, "what reaches higher above the ground is taken apart into things [m]", 0,
          10);
  v.field("ground_height_m", ground_height_m, "what is lower is the ground [m]", 0, 10);
  v.field("gap_m", gap_m, "things are about this far apart, more beyond 15 m [m]", 0.05, 5);
  v.field("whole_share", whole_share, "a thing goes as a whole when this share of its points moved", 0, 1);
  v.field("part_share", part_share, "part of a thing goes when this share of the part's points moved", 0, 1);
  v.field("min_object_points", min_object_points, "and so many did, at least", 1, 1000000);
  v.field("min_part_points", min_part_points, "or so many, of a part", 1, 1000000);
  v.field("cache_mb", cache_mb, "memory for scans that testify, made ready [MB]", 0, 1e6);
}

namespace {

constexpr std::size_t kBatch = 8;        ///< keyframes judged side by side
constexpr std::size_t kGroundScans = 8;  ///< of the views soon and later that say where the ground is
constexpr const char* kReport = "clean.json";

/// Keyframes whose scans testify about one, of those within reach, increasing.
struct Around {
  std::vector<KeyframeId> soon;   ///< taken just before and after it
  std::vector<KeyframeId> later;  ///< of the others, evenly spread over time
};

Around around(KeyframeId k, const SavedMap& map, const CleanParams& params) {
  Around around;
  const auto soon = static_cast<KeyframeId>(params.soon_views / 2);
  const Eigen::Vector3d here = map.poses()[k].translation();
  for (KeyframeId other = 0; other < map.keyframes().size(); ++other) {
    if (other == k || (map.poses()[other].translation() - here).norm() > params.reach_m) continue;
    (std::max(k, other) - std::min(k, other) <= soon ? around.soon : around.later).push_back(other);
  }
  around.later = evenlySpread(around.later, static_cast<std::size_t>(params.later_views));
  return around;
}

std::vector<KeyframeId> allOf(const SavedMap& map) {
  std::vector<KeyframeId> all(map.keyframes().size());
  std::iota(all.begin(), all.end(), KeyframeId{0});
  return all;
}

/// A scan taken apart.
struct Parted {
  ScanVerdict verdict;
  bool viewed = false;
  Cloud stays, goes;
  Descriptor stays_descriptor, goes_descriptor;
  Cloud cloud_map;  ///< whole, only where labels are to be compared
};

void checkCleanable(const SavedMap& map, const PluginContext& context) {
  const fs::path& folder = map.session().folder();
  if (map.keyframes().size() < 2)
    throw inputError("{} holds one keyframe with a scan; cleaning compares scans and needs two", folder.string());
  if (!map.session().complete())
    logWarn(context.log, "{} was not completed; what it holds so far is cleaned", folder.string());
  if (map.keyframesWithoutScan() > 0)
    logWarn(context.log, "{}: {} of {} keyframes have no scan and are left out", folder.string(),
            map.keyframesWithoutScan(), map.session().keyframes().size());
}

class Cleaner {
 public:
  Cleaner(const SavedMap& map, const CleanConfig& config, const fs::path& folder, const PluginContext& context)
      : map_(map),
        params_(config.clean),
        context_(context),
        views_(map, allOf(map), params_.cache_mb * 1e6),
        static_(map, folder / "static", config.slam.place, context),
        dynamic_(map, folder / "dynamic", config.slam.place, context) {}

  /// @param labels null: no scores. @param progress called with the keyframes done; may throw to end.
  void run(const TrueLabels* labels, CleanSummary& summary, const std::function<void(std::size_t)>& progress) {
    const std::size_t n = map_.keyframes().size();
    CleanScorer scorer;
    for (std::size_t begin = 0; begin < n; begin += kBatch) {
      const std::size_t end = std::min(n, begin + kBatch);
      progress(begin);
      std::vector<Around> witnesses;
      std::set<KeyframeId> needed;
      for (std::size_t k = begin; k < end; ++k) {
        const Around& a = witnesses.emplace_back(around(static_cast<KeyframeId>(k), map_, params_));
        needed.insert(static_cast<KeyframeId>(k));
        needed.insert(a.soon.begin(), a.soon.end());
        needed.insert(a.later.begin(), a.later.end());
      }
      views_.prepare(needed, context_);
      std::vector<Parted> parts(end - begin);
      context_.threads.forEachChunk(parts.size(), 1, [&](std::size_t i, std::size_t, std::size_t) {
        parts[i] = part(static_cast<KeyframeId>(begin + i), witnesses[i], labels != nullptr);
      });
      for (std::size_t i = 0; i < parts.size(); ++i) {
        const auto k = static_cast<KeyframeId>(begin + i);
        if (labels != nullptr)
          scorer.add(parts[i].cloud_map, labels->of(map_.keyframes()[k].scan_index, parts[i].cloud_map.size()),
                     parts[i].verdict.dynamic);
        static_.add(k, parts[i].stays, parts[i].stays_descriptor);
        dynamic_.add(k, parts[i].goes, parts[i].goes_descriptor);
        count(parts[i], summary);
      }
    }
    static_.finish();
    dynamic_.finish();
    if (labels != nullptr) summary.score = scorer.score();
  }

 private:
  Parted part(KeyframeId k, const Around& around, bool with_map) const {
    Parted parted;
    const Cloud cloud = scanOf(map_, k);
    const Pose T_map_sensor = views_.T_map_sensor(k);
    const Cloud cloud_map = transformed(cloud, T_map_sensor);
    parted.viewed = !around.soon.empty() || !around.later.empty();
    const SightMargins margins{static_cast<float>(params_.margin_m), static_cast<float>(params_.margin_per_m), 1,
                               static_cast<float>(params_.sky_m)};
    parted.verdict =
        judgeScan(cloud, heights(k, cloud_map, around), views_.ask(around.soon, cloud, T_map_sensor, margins),
                  views_.ask(around.later, cloud, T_map_sensor, margins), T_map_sensor, params_);
    const std::vector<std::uint8_t>& goes = parted.verdict.dynamic;
    std::vector<std::uint8_t> stays(goes.size());
    for (std::size_t i = 0; i < goes.size(); ++i) stays[i] = goes[i] == 0 ? 1 : 0;
    parted.stays = cloud, parted.goes = cloud;
    parted.stays.filter(stays), parted.goes.filter(goes);
    parted.stays_descriptor = static_.describe(k, parted.stays);
    parted.goes_descriptor = dynamic_.describe(k, parted.goes);
    if (with_map) parted.cloud_map = cloud_map;
    return parted;
  }

  /// Of each point over the ground that the scan and those around it saw; infinite for planar scans.
  std::vector<float> heights(KeyframeId k, const Cloud& cloud_map, const Around& around) const {
    std::vector<float> heights(cloud_map.size(), std::numeric_limits<float>::infinity());
    if (views_.grid().planar) return heights;
    std::vector<const std::vector<LowPoint>*> low = {&views_.at(k).low_points};
    for (const std::vector<KeyframeId>* views : {&around.soon, &around.later}) {
      const std::size_t step = std::max<std::size_t>(1, views->size() / kGroundScans);
      for (std::size_t i = 0; i < views->size(); i += step) low.push_back(&views_.at((*views)[i]).low_points);
    }
    const GroundCells ground(low);
    for (std::size_t i = 0; i < heights.size(); ++i) heights[i] = ground.heightOf(cloud_map.point(i));
    return heights;
  }

  static void count(const Parted& parted, CleanSummary& summary) {
    summary.points += parted.stays.size() + parted.goes.size();
    summary.removed += parted.goes.size();
    summary.completed += parted.verdict.completed, summary.reverted += parted.verdict.reverted;
    summary.objects += parted.verdict.objects;
    summary.keyframes_without_views += parted.viewed ? 0 : 1;
  }

  const SavedMap& map_;
  const CleanParams& params_;
  const PluginContext& context_;
  Views views_;
  CleanedSession static_, dynamic_;
};

/// The map of a session in its folder. @return its points.
std::size_t exportPly(const fs::path& session, const PluginContext& context) {
  return exportMap(Session::open(session), {"ply"}, {}, session / "map", context).points_written;
}

}  // namespace

CleanSummary cleanSession(const CleanOptions& options, const PluginContext& context) {
  const auto start = std::chrono::steady_clock::now();
  const auto tick = [&options] {
    if (options.stop != nullptr && *options.stop) throw Error(ExitCode::kStopped, "stopped; nothing was written");
  };
  Session session = Session::open(options.session);
  CleanConfig config;
  loadSessionConfig(config.slam, session, context);
  for (const auto& file : options.configs) loadConfig(config, file);
  for (const auto& assignment : options.sets) setParam(config, assignment);
  std::optional<TrueLabels> labels;
  if (!options.labels.empty()) labels.emplace(options.labels, options.label_style);
  const Pose T_base_sensor = session.info().T_base_sensor;
  const SavedMap map(std::move(session), T_base_sensor, {}, 0);
  checkCleanable(map, context);

  const fs::path output = options.output.empty() ? options.session / "clean" : options.output;
  PartialFolder partial(output, {options.session},
                        {"cleaned session", kReport, {"static", "dynamic", kReport, "clean.png"}}, options.overwrite);
  CleanSummary summary;
  summary.folder = output;
  summary.keyframes = map.keyframes().size();
  summary.keyframes_without_scan = map.keyframesWithoutScan();
  Progress progress("keyframes", summary.keyframes, options.quiet);
  Cleaner(map, config, partial.folder(), context).run(labels ? &*labels : nullptr, summary, [&](std::size_t done) {
    tick();
    progress.update(done);
  });
  progress.finish();
  if (summary.keyframes_without_views > 0)
    logWarn(context.log, "{} of {} scans have no other within {} m (clean.reach_m): nothing was removed from them",
            summary.keyframes_without_views, summary.keyframes, config.clean.reach_m);
  summary.static_map_points = exportPly(partial.folder() / "static", context);
  tick();
  summary.dynamic_map_points = exportPly(partial.folder() / "dynamic", context);
  tick();
  summary.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  summary.peak_rss_mb = peakRssMb();
  writeFileAtomically(partial.folder() / kReport, cleanJson(summary));
  partial.replaceTarget();
  return summary;
}

}  // namespace scslam
