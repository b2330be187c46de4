#include "scslam/apps/merge/write_merged.h"

#include <algorithm>
#include <cmath>

#include "scslam/apps/alignment.h"
#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/session/layout.h"
#include "scslam/session/session_graph.h"
#include "scslam/session/session_writer.h"

namespace scslam {
namespace fs = std::filesystem;
namespace {

/// Way between the end of one parent and the begin of the next: no submap, no candidate reaches across it.
constexpr double kBetweenParents_m = 1000;
/// Time between them at least: no trajectory is interpolated across it.
constexpr std::int64_t kBetweenParents_s = 10;

Stamp::duration wholeSeconds(std::int64_t seconds) {
  return std::chrono::duration_cast<Stamp::duration>(std::chrono::seconds(seconds));
}

std::pair<Stamp, Stamp> span(const SavedMap& map) {
  Stamp first = map.keyframes().front().stamp, last = map.keyframes().back().stamp;
  for (const ScanRecord& scan : map.scans()) first = std::min(first, scan.stamp), last = std::max(last, scan.stamp);
  return {first, last};
}

class MergedWriter {
 public:
  MergedWriter(SessionWriter& writer, const std::vector<SavedMap>& maps, const SessionUnion& joined)
      : writer_(writer), maps_(maps), joined_(joined), places_(placesOf(maps, joined)) {}

  void writeSession(std::size_t s, const std::vector<Descriptor>& descriptors, const std::function<void()>& tick) {
    const SavedMap& map = maps_[s];
    for (Keyframe keyframe : map.keyframes()) {
      tick();
      const KeyframeId k = keyframe.id;
      keyframe.id += places_.first_keyframe[s];
      keyframe.scan_index += places_.first_scan[s];
      keyframe.stamp += places_.time_offset[s];
      keyframe.travelled_m += places_.way_offset_m[s];
      keyframe.T_odom_base = places_.T_odom_own[s] * keyframe.T_odom_base;
      if (k == 0 && s != joined_.members.front()) keyframe.step_covariance = kOpenStep * Matrix6d::Identity();
      writer_.addKeyframe(keyframe, joined_.T_map_base[s][k], map.session().cloud(map.ownNumber(k)), descriptors[k]);
    }
    for (ScanRecord scan : map.scans()) {
      scan.index += places_.first_scan[s];
      scan.stamp += places_.time_offset[s];
      scan.T_odom_base = places_.T_odom_own[s] * scan.T_odom_base;
      scan.keyframe += places_.first_keyframe[s];
      writer_.addScan(scan);
    }
    for (GnssRecord record : map.gnss()) {
      record.keyframe += places_.first_keyframe[s];
      record.fix.stamp += places_.time_offset[s];
      writer_.addGnss(record);
    }
  }
  void writeLoops(const std::vector<LoopRecord>& loops, std::size_t a, std::size_t b) {
    for (LoopRecord loop : loops) {
      loop.match += places_.first_keyframe[a], loop.query += places_.first_keyframe[b];
      writer_.addLoop(loop);
    }
  }
  const MemberPlaces& places() const { return places_; }

 private:
  SessionWriter& writer_;
  const std::vector<SavedMap>& maps_;
  const SessionUnion& joined_;
  MemberPlaces places_;
};

std::string csvField(std::string text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  for (std::size_t i = 0; (i = text.find('"', i)) != std::string::npos; i += 2) text.insert(i, 1, '"');
  return '"' + text + '"';
}

std::string parentsCsv(const std::vector<SavedMap>& maps, const std::vector<std::string>& names,
                       const SessionUnion& joined, const MemberPlaces& places) {
  std::string text =
      "parent,name,first_keyframe,keyframes,first_scan,scans,time_offset_s,tx,ty,tz,qx,qy,qz,qw,folder\n";
  std::size_t parent = 0;  // as session.yaml counts them
  for (const std::size_t s : joined.members) {
    const Pose T = alignPoses(joined.T_map_base[s], maps[s].poses());
    Eigen::Quaterniond q(T.linear());
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    const auto& t = T.translation();
    text += fmt::format("{},{},{},{},{},{},{},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{}\n", parent++,
                        csvField(names[s]), places.first_keyframe[s], maps[s].keyframes().size(), places.first_scan[s],
                        maps[s].scans().size(), std::chrono::duration<double>(places.time_offset[s]).count(), t.x(),
                        t.y(), t.z(), q.x(), q.y(), q.z(), q.w(), csvField(maps[s].origin().string()));
  }
  return text;
}

void writeTables(const fs::path& folder, const std::vector<SavedMap>& maps, const std::vector<std::string>& names,
                 const SessionUnion& joined, const MemberPlaces& places, const Pose& T_base_sensor) {
  writeFileAtomically(folder / layout::kParents, parentsCsv(maps, names, joined, places));
  std::string keyframes = "keyframe,parent,parent_keyframe\n";
  const fs::path lt_mapper = folder / layout::kLtMapper;
  fs::create_directories(lt_mapper);
  std::size_t parent = 0;
  for (const std::size_t s : joined.members) {
    std::vector<Pose> central, local;
    const Pose T_own_map = alignPoses(joined.T_map_base[s], maps[s].poses()).inverse();
    for (KeyframeId k = 0; k < joined.T_map_base[s].size(); ++k) {
      keyframes += fmt::format("{},{},{}\n", places.first_keyframe[s] + k, parent, maps[s].ownNumber(k));
      central.push_back(joined.T_map_base[s][k] * T_base_sensor);
      local.push_back(T_own_map * central.back());
    }
    const auto write = [&](const char* frame, const std::vector<Pose>& poses) {
      writeFileAtomically(lt_mapper / fmt::format("{}_{}_aft_intersession_loops.txt", names[s], frame),
                          formatKitti(poses));
    };
    write("central", central);
    write("local", local);
    ++parent;
  }
  writeFileAtomically(folder / layout::kKeyframeParents, keyframes);
}

}  // namespace

MemberPlaces placesOf(const std::vector<SavedMap>& maps, const SessionUnion& joined) {
  const std::size_t n = maps.size();
  MemberPlaces places{std::vector<KeyframeId>(n), std::vector<Stamp::duration>(n, Stamp::duration::zero()),
                      std::vector<std::size_t>(n), std::vector<double>(n), std::vector<Pose>(n, Pose::Identity())};
  KeyframeId keyframe = 0;
  std::size_t scan = 0, before = n;
  Stamp end;
  double way_m = 0;
  for (const std::size_t s : joined.members) {
    const std::vector<Keyframe>& own = maps[s].keyframes();
    const auto [first, last] = span(maps[s]);
    if (before != n) {
      const std::int64_t missing = kBetweenParents_s - std::chrono::floor<std::chrono::seconds>(first - end).count();
      if (missing > 0) places.time_offset[s] = wholeSeconds(missing);
      places.way_offset_m[s] = way_m + kBetweenParents_m - own.front().travelled_m;
      const Pose T_last_first = joined.T_map_base[before].back().inverse() * joined.T_map_base[s].front();
      places.T_odom_own[s] = places.T_odom_own[before] * maps[before].keyframes().back().T_odom_base * T_last_first *
                             own.front().T_odom_base.inverse();
    }
    places.first_keyframe[s] = keyframe, places.first_scan[s] = scan;
    keyframe += static_cast<KeyframeId>(own.size());
    std::size_t scans = own.back().scan_index + 1;
    for (const ScanRecord& record : maps[s].scans()) scans = std::max(scans, record.index + 1);
    scan += scans;
    end = last + places.time_offset[s];
    way_m = places.way_offset_m[s] + own.back().travelled_m;
    before = s;
  }
  return places;
}

void writeMerged(const fs::path& folder, const SessionInfo& info, const std::vector<SavedMap>& maps,
                 const std::vector<std::string>& names, const std::vector<SessionPair>& pairs,
                 const SessionUnion& joined, const std::vector<std::vector<Descriptor>>& descriptors,
                 const std::function<std::string()>& metrics, const std::function<void()>& tick) {
  const auto writer = SessionWriter::create(folder, info, true);
  MergedWriter merged(*writer, maps, joined);
  for (const std::size_t s : joined.members) merged.writeSession(s, descriptors[s], tick);
  for (const std::size_t s : joined.members) merged.writeLoops(joined.own_loops[s], s, s);
  const auto member = [&joined](std::size_t s) {
    return std::find(joined.members.begin(), joined.members.end(), s) != joined.members.end();
  };
  for (const SessionPair& pair : pairs)
    if (member(pair.a) && member(pair.b)) merged.writeLoops(pair.loops->records(), pair.a, pair.b);
  writer->setPoses(joined.graph.poses);
  writer->finish(joined.graph);
  writer->writeMetrics(metrics());
  writeTables(folder, maps, names, joined, merged.places(), info.T_base_sensor);
}

}  // namespace scslam
