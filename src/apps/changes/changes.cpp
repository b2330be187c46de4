#include "scslam/apps/changes/changes.h"

#include <algorithm>
#include <chrono>
#include <sstream>

#include "scslam/apps/changes/visit.h"
#include "scslam/apps/partial_folder.h"
#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/peak_memory.h"
#include "scslam/core/progress.h"
#include "scslam/session/layout.h"

namespace scslam {
namespace fs = std::filesystem;

void ChangeParams::describe(ParamVisitor& v) {
  v.field("reach_m", reach_m, "how far from a scan the other visit's scans may have been taken [m]", 1, 1e4);
  v.field("views", views, "scans of the other visit that a scan is held against, at most", 1, 255);
  v.field("own_views", own_views, "scans of its own visit, just before and after it: what moves is no change", 2, 120);
  v.field("margin_m", margin_m, "a point this much nearer than all that a scan saw there was looked through [m]", 0.01,
          10);
  v.field("margin_per_m", margin_per_m, "and this much more for each metre of its range", 0, 1);
  v.field("voxel_m", voxel_m, "edge of the voxels that are compared [m]", 0.02, 10);
  v.field("min_free", min_free, "looks through a voxel's points that it takes", 1, 1000000);
  v.field("free_share", free_share, "and their share among all that saw its place", 0, 1);
  v.field("gap_m", gap_m, "changed voxels this far apart are one thing [m]", 0.02, 10);
  v.field("min_voxels", min_voxels, "things of fewer voxels are no change", 1, 1000000);
  v.field("cache_mb", cache_mb, "memory for scans that testify, made ready [MB]", 0, 1e6);
}

namespace {

constexpr const char* kReport = "changes.json";

/// Parent of each keyframe, by number in session.yaml. @throw inputError for a session without or with a damaged table.
std::vector<std::size_t> parentOfKeyframes(const Session& session) {
  const fs::path file = session.folder() / layout::kKeyframeParents;
  if (session.info().parents.empty() || !fs::exists(file))
    throw inputError("{} is not a merged session; 'scslam merge OLDER NEWER -o BOTH' makes one",
                     session.folder().string());
  std::istringstream table(readFile(file));
  std::vector<std::size_t> parents;
  std::string line;
  std::getline(table, line);
  while (std::getline(table, line)) {
    std::size_t keyframe = 0, parent = 0, own = 0;
    if (std::sscanf(line.c_str(), "%zu,%zu,%zu", &keyframe, &parent, &own) != 3 || keyframe != parents.size() ||
        parent >= session.info().parents.size())
      throw inputError("{}:{}: '{}' is no keyframe, parent, number", file.string(), parents.size() + 2, line);
    parents.push_back(parent);
  }
  if (parents.size() != session.keyframes().size())
    throw inputError("{} lists {} keyframes, the session has {}", file.string(), parents.size(),
                     session.keyframes().size());
  return parents;
}

std::size_t parentNamed(const std::string& name, std::size_t otherwise, const Session& session) {
  const auto& parents = session.info().parents;
  std::string names;
  for (std::size_t i = 0; i < parents.size(); ++i) {
    if (parents[i].name == name) return i;
    names += (i > 0 ? ", " : "") + parents[i].name;
  }
  if (!name.empty()) throw usageError("{} has no parent '{}'; it has {}", session.folder().string(), name, names);
  return otherwise;
}

std::vector<KeyframeId> keyframesOf(std::size_t parent, const std::vector<std::size_t>& parents, const SavedMap& map) {
  std::vector<KeyframeId> keyframes;
  for (KeyframeId k = 0; k < map.keyframes().size(); ++k)
    if (parents[map.ownNumber(k)] == parent) keyframes.push_back(k);
  return keyframes;
}

/// Binary PLY: x y z, red green blue, change (0 stayed, 1 appeared, 2 disappeared, 3 unseen by the other visit).
std::string plyOf(const ChangeMap& map) {
  constexpr std::uint8_t kColours[4][3] = {{150, 150, 150}, {40, 200, 80}, {230, 50, 50}, {60, 70, 110}};
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment scslam changes, frame map, metres; change: 0 stayed, 1 appeared, "
      "2 "
      "disappeared, 3 seen by one visit only\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar change\nend_header\n",
      map.change.size());
  for (std::size_t i = 0; i < map.change.size(); ++i) {
    const Eigen::Vector3f p = map.cloud_map.point(i);
    bytes.append(reinterpret_cast<const char*>(p.data()), 12);
    const auto change = static_cast<std::size_t>(map.change[i]);
    bytes.append(reinterpret_cast<const char*>(kColours[change]), 3);
    bytes.push_back(static_cast<char>(change));
  }
  return bytes;
}

std::string csvOf(const std::vector<ChangedThing>& things) {
  std::string text = "change,x,y,z,length_m,width_m,height_m,voxels\n";
  for (const ChangedThing& thing : things) {
    const Eigen::Vector3f middle = 0.5F * (thing.low + thing.high), size = thing.high - thing.low;
    text += fmt::format("{},{:.2f},{:.2f},{:.2f},{:.2f},{:.2f},{:.2f},{}\n",
                        thing.change == Change::kAppeared ? "appeared" : "disappeared", middle.x(), middle.y(),
                        middle.z(), size.x(), size.y(), size.z(), thing.voxels);
  }
  return text;
}

void count(ChangesSummary& summary) {
  const auto of = [&summary](Change change) {
    return static_cast<std::size_t>(std::count(summary.map.change.begin(), summary.map.change.end(), change));
  };
  summary.stayed = of(Change::kStayed), summary.unseen = of(Change::kUnseen);
  summary.appeared = of(Change::kAppeared), summary.disappeared = of(Change::kDisappeared);
  std::stable_sort(summary.things.begin(), summary.things.end(),
                   [](const auto& a, const auto& b) { return a.voxels > b.voxels; });
}

}  // namespace

ChangesSummary findChanges(const ChangesOptions& options, const PluginContext& context) {
  const auto start = std::chrono::steady_clock::now();
  ChangeParams params;
  for (const auto& assignment : options.sets) setParam(params, assignment);
  Session session = Session::open(options.session);
  const std::vector<std::size_t> parents = parentOfKeyframes(session);
  const std::size_t older = parentNamed(options.older, 0, session),
                    newer = parentNamed(options.newer, session.info().parents.size() - 1, session);
  if (older == newer)
    throw usageError("{} cannot be compared with itself; name two parents of the session",
                     session.info().parents[older].name);
  ChangesSummary summary;
  summary.older = session.info().parents[older].name, summary.newer = session.info().parents[newer].name;
  summary.folder = options.output.empty() ? options.session / "changes" : options.output;
  const Pose T_base_sensor = session.info().T_base_sensor;
  const SavedMap map(std::move(session), T_base_sensor, {}, 0);
  PartialFolder partial(summary.folder, {options.session},
                        {"comparison", kReport, {"changes.ply", "things.csv", "changes.png", kReport}},
                        options.overwrite);

  Visit before(map, keyframesOf(older, parents, map), params), after(map, keyframesOf(newer, parents, map), params);
  summary.older_keyframes = before.keyframes().size(), summary.newer_keyframes = after.keyframes().size();
  Progress progress("keyframes", summary.older_keyframes + summary.newer_keyframes, options.quiet);
  const auto tick = [&](std::size_t done) {
    if (options.stop != nullptr && *options.stop) throw Error(ExitCode::kStopped, "stopped; nothing was written");
    progress.update(done);
  };
  before.compare(after, context, tick);
  after.compare(before, context, [&](std::size_t done) { tick(summary.older_keyframes + done); });
  progress.finish();
  before.report(Change::kDisappeared, summary.map, summary.things);
  after.report(Change::kAppeared, summary.map, summary.things);
  summary.moving_points = before.movingPoints() + after.movingPoints();
  count(summary);

  writeFileAtomically(partial.folder() / "changes.ply", plyOf(summary.map));
  writeFileAtomically(partial.folder() / "things.csv", csvOf(summary.things));
  summary.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  summary.peak_rss_mb = peakRssMb();
  writeFileAtomically(partial.folder() / kReport, changesJson(summary));
  partial.replaceTarget();
  return summary;
}

}  // namespace scslam
