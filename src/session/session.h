// A saved session, opened for reading. Also opens what a killed run left (from its journal) and classic SC-A-LOAM
// folders.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "scslam/session/session_writer.h"

namespace scslam {

class Session {
 public:
  /// A session that was not completed is read from its journal: the valid prefix. A classic folder (no session.yaml,
  /// but optimized_poses.txt, times.txt and Scans) has every pose as a keyframe and a scan, sensor = base; loops are
  /// the edges of its g2o file between keyframes that do not follow each other.
  /// @throw inputError when `folder` is no session or is damaged (what, which file, what `scslam doctor` says).
  static Session open(const std::filesystem::path& folder);

  const std::filesystem::path& folder() const { return folder_; }
  const SessionInfo& info() const { return info_; }
  bool complete() const { return complete_; }
  bool classic() const { return classic_; }
  const std::vector<Keyframe>& keyframes() const { return keyframes_; }
  const std::vector<Pose>& poses() const { return T_map_base_; }  ///< per keyframe
  const std::vector<ScanRecord>& scans() const { return scans_; }
  const std::vector<LoopRecord>& loops() const { return loops_; }
  const std::vector<GnssRecord>& gnss() const { return gnss_; }
  /// T_map_base of every scan: the correction of its keyframe applied to its odometry.
  std::vector<StampedPose> trajectory() const;
  std::vector<StampedPose> odometry() const;
  /// Is there a scan of keyframe k? Always in our sessions; classic folders may have lost some.
  bool hasCloud(KeyframeId k) const;
  /// Cloud of keyframe k, frame sensor, read from disk. @throw inputError when it is missing or damaged.
  Cloud cloud(KeyframeId k) const;
  /// Descriptor of keyframe k, read from disk. @throw inputError when it is missing or damaged.
  Descriptor descriptor(KeyframeId k) const;
  /// Odometry factors and accepted loops over poses().
  PoseGraph graph() const;

 private:
  void openOwn();
  void openClassic();
  std::filesystem::path folder_;
  SessionInfo info_;
  bool complete_ = false, classic_ = false;
  std::vector<Keyframe> keyframes_;
  std::vector<Pose> T_map_base_;
  std::vector<ScanRecord> scans_;
  std::vector<LoopRecord> loops_;
  std::vector<GnssRecord> gnss_;
};

}  // namespace scslam
