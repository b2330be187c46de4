// Sessions made of given poses and clouds, every scan a keyframe.
#pragma once
#include <filesystem>
#include <functional>
#include <vector>

#include "scslam/session/session.h"
#include "scslam/session/session_graph.h"
#include "scslam/session/session_writer.h"

namespace scslam::test {

struct SessionParts {
  std::vector<Pose> odometry, optimised;  ///< T_odom_base, T_map_base; equally many
  std::vector<LoopRecord> loops = {};     ///< in any order
  std::function<Cloud(std::size_t k)> cloud_sensor = [](std::size_t) { return Cloud{}; };
  Pose T_base_sensor = Pose::Identity();
  bool planar = false;
  std::vector<GnssRecord> gnss = {};
  std::vector<SessionParent> parents = {};
};

inline LoopRecord acceptedLoop(KeyframeId match, KeyframeId query, const Pose& T_match_query) {
  LoopRecord loop;
  loop.match = match;
  loop.query = query;
  loop.registered = loop.accepted = true;
  loop.reason = "accepted";
  loop.T_match_query = T_match_query;
  loop.information = 100 * Matrix6d::Identity();
  return loop;
}

/// Stamps are 1000, 1000.1, … s.
inline Session sessionOf(const std::filesystem::path& folder, const SessionParts& parts) {
  SessionInfo info;
  info.T_base_sensor = parts.T_base_sensor;
  info.planar = parts.planar;
  info.parents = parts.parents;
  const auto writer = SessionWriter::create(folder, info, false);
  std::vector<Keyframe> keyframes;
  for (std::size_t k = 0; k < parts.odometry.size(); ++k) {
    Keyframe keyframe;
    keyframe.id = static_cast<KeyframeId>(k);
    keyframe.scan_index = k;
    keyframe.stamp = stampFromSeconds(1000 + 0.1 * static_cast<double>(k));
    keyframe.T_odom_base = parts.odometry[k];
    keyframe.planar = parts.planar;
    writer->addKeyframe(keyframe, parts.optimised[k], parts.cloud_sensor(k), Descriptor::Zero(2, 3));
    writer->addScan({k, keyframe.stamp, keyframe.T_odom_base, static_cast<std::int64_t>(k)});
    keyframes.push_back(keyframe);
  }
  for (const LoopRecord& loop : parts.loops) writer->addLoop(loop);
  for (const GnssRecord& fix : parts.gnss) writer->addGnss(fix);
  writer->finish(buildGraph(keyframes, parts.loops, parts.optimised, parts.planar));
  return Session::open(folder);
}

inline Trajectory untimed(const std::vector<Pose>& poses) {
  Trajectory trajectory;
  trajectory.timed = false;
  for (const Pose& T : poses) trajectory.poses.push_back({Stamp{}, T});
  return trajectory;
}

}  // namespace scslam::test
