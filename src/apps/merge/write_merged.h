// The union of sessions as a session of its own.
#pragma once
#include <filesystem>
#include <vector>

#include "scslam/apps/merge/union_graph.h"

namespace scslam {

/// Where each member's keyframes and times begin in the merged session.
struct MemberPlaces {
  std::vector<KeyframeId> first_keyframe;    ///< by session
  std::vector<Stamp::duration> time_offset;  ///< by session: keeps the merged session's times increasing
  std::vector<std::size_t> first_scan;       ///< by session
  std::vector<double> way_offset_m;          ///< by session
  std::vector<Pose> T_odom_own;              ///< by session: its odometry frame in the merged session's
};
MemberPlaces placesOf(const std::vector<SavedMap>& maps, const SessionUnion& joined);

/// Writes keyframes, scans, fixes, loops and graph, and the poses of each parent as LT-mapper reads them
/// (lt_mapper/NAME_central_aft_intersession_loops.txt: row-major 3x4 T_map_sensor, one line per keyframe).
/// @param names of the sessions, unique. @param descriptors by session and keyframe. @param folder new or empty.
/// @param metrics makes metrics.json, last. @param tick called before each keyframe; may throw to end.
void writeMerged(const std::filesystem::path& folder, const SessionInfo& info, const std::vector<SavedMap>& maps,
                 const std::vector<std::string>& names, const std::vector<SessionPair>& pairs,
                 const SessionUnion& joined, const std::vector<std::vector<Descriptor>>& descriptors,
                 const std::function<std::string()>& metrics, const std::function<void()>& tick);

}  // namespace scslam
