// The session folder while a run goes on (README, "The session folder"): append-only, survives kill -9 at any instant.
#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "scslam/core/cloud.h"
#include "scslam/core/trajectory.h"
#include "scslam/place/place_recogniser.h"
#include "scslam/session/records.h"

namespace scslam {

/// One of the sessions that a merged one was made of.
struct SessionParent {
  std::string name;                 ///< its folder's name
  std::string digest;               ///< of its keyframes: tells sessions apart wherever they lie
  std::vector<std::string> leaves;  ///< digests of its own parents, where it is a merged one; all generations
};

/// What is fixed when the session begins; written to session.yaml (a resumed run must agree with it).
struct SessionInfo {
  std::string input;         ///< as the user named it
  std::string input_format;  ///< reader
  std::string input_digest;  ///< of the input's file names and sizes
  std::string config_yaml;   ///< resolved configuration, also written to config.yaml
  std::string odometry, recogniser, registration;
  std::string sensor_label;
  std::string sensor_table;  ///< shipped name or file that the user gave; empty: the reader's
  Pose T_base_sensor = Pose::Identity();
  bool planar = false;
  std::vector<SessionParent> parents;  ///< of a merged session, in the order of its keyframes
};

/// What a killed run had recorded at its last checkpoint.
struct RecoveredSession {
  std::vector<ScanRecord> scans;
  std::vector<Keyframe> keyframes;
  std::vector<LoopRecord> loops;
  std::vector<Pose> T_map_base;  ///< per keyframe
  std::vector<Descriptor> descriptors;
  std::vector<GnssRecord> gnss;
  std::string pipeline_state;  ///< the blob given to checkpoint(); empty: no checkpoint yet, start from the beginning
};

/// A write that fails (disk full) throws an Error; the session then stands, resumable, and every later call repeats
/// that error.
class SessionWriter {
 public:
  /// Starts a new session in `folder`.
  /// @param overwrite an existing session there is removed first; a folder that holds anything but a session is never
  /// removed.
  /// @throw usageError when it exists and may not be replaced (the message names -w and --resume); Error when it cannot
  /// be written.
  static std::unique_ptr<SessionWriter> create(const std::filesystem::path& folder, const SessionInfo& info,
                                               bool overwrite);
  /// Opens a session that was stopped or killed, cuts everything after its last checkpoint off, and returns what
  /// stands.
  /// @throw usageError when there is none, it is complete, or it was made from another input or configuration.
  static std::unique_ptr<SessionWriter> resume(const std::filesystem::path& folder, const SessionInfo& info,
                                               RecoveredSession& recovered);

  virtual ~SessionWriter() = default;
  virtual void addScan(const ScanRecord& scan) = 0;
  /// Writes Scans/NNNNNN.pcd (frame sensor) and SCDs/NNNNNN.scd, then the journal record. @param T_map_base current
  /// estimate.
  virtual void addKeyframe(const Keyframe& keyframe, const Pose& T_map_base, const Cloud& cloud_sensor,
                           const Descriptor& descriptor) = 0;
  virtual void addLoop(const LoopRecord& loop) = 0;
  /// Changes the verdict on a loop given to addLoop() before.
  virtual void judgeLoop(const LoopVerdict& verdict) = 0;
  virtual void addGnss(const GnssRecord& gnss) = 0;
  /// All keyframes moved (after an optimisation).
  virtual void setPoses(const std::vector<Pose>& T_map_base) = 0;
  /// A line of run.log (no wall clock in it).
  virtual void logLine(const std::string& line) = 0;
  /// From here a killed run goes on. Replaces checkpoint.bin atomically and brings the text files up to date.
  virtual void checkpoint(const std::string& pipeline_state) = 0;
  /// Brings all files up to date, state: complete.
  /// @param graph the final graph, nodes = keyframes, factors = odometry and accepted loops.
  virtual void finish(const PoseGraph& graph) = 0;
  virtual void writeMetrics(const std::string& json) = 0;
  /// Nothing follows, pictures included: checkpoint.bin goes, there is nothing to resume. Not called where the user
  /// stopped the run. A run killed before goes on from its last checkpoint and makes again what was to follow.
  virtual void seal() = 0;
  virtual const std::filesystem::path& folder() const = 0;
};

}  // namespace scslam
