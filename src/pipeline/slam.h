// The paper's figure: sensor -> odometry -> keyframe -> place -> registration -> graph -> session.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "scslam/graph/incremental_optimiser.h"
#include "scslam/pipeline/loop_closer.h"
#include "scslam/pipeline/loop_ledger.h"
#include "scslam/pipeline/satellites.h"
#include "scslam/pipeline/stages.h"
#include "scslam/session/cloud_store.h"
#include "scslam/session/session_writer.h"

namespace scslam {

struct SlamCounts {
  std::size_t scans = 0, keyframes = 0, candidates = 0, loops = 0;
  std::size_t empty_scans = 0, late_scans = 0,
              lost_scans = 0;  ///< no usable point; stamp not after the one before; odometry failed
};

enum class SessionEnd {
  kDone,        ///< all of the input is in it
  kEndedEarly,  ///< all that the damaged input gave
  kStopped,     ///< by the user: whole as it is, and --resume can go on from its last checkpoint
};

class Slam {
 public:
  /// @param session where everything is recorded as it happens; outlives this.
  Slam(const SlamParams& params, const PluginContext& context, SessionWriter& session, const Pose& T_base_sensor);

  /// Before the first scan: what the front-end may need to know of the source.
  void begin(std::optional<std::size_t> scan_count, const Pose& T_base_reference);
  /// Goes on from what a killed run had recorded. @return how many scans of the source it had taken.
  std::size_t resume(RecoveredSession recovered);

  void process(Scan scan);

  /// At the end: asks once more about every keyframe without a loop, now that all poses are corrected (the drift may
  /// have hidden a place, or the newest poses were not known yet). finish() corrects the map with the loops found.
  /// @param go_on told how many of how many are done; false ends the search.
  void lookAgain(const std::function<bool(std::size_t, std::size_t)>& go_on);

  /// Makes the present point one a later run can go on from.
  void checkpoint();
  /// Brings the session folder up to date.
  void finish(SessionEnd end);

  const SlamCounts& counts() const { return counts_; }
  const std::vector<Keyframe>& keyframes() const { return keyframes_; }
  /// Odometry and the accepted loops.
  PoseGraph graph() const;
  const StageTimes& times() const { return times_; }

 private:
  bool inOrder(const Scan& scan);
  void takePoints(Scan& sweep);
  void addKeyframe(const Scan& scan, const OdometryStep& step);
  void closeLoops();
  /// @return whether a loop was accepted.
  bool closeLoops(KeyframeId query);
  void collectFixes(const Scan& scan, const OdometryStep& step);
  void solveOnline();
  void solveAll();
  void takeSolution(const std::vector<std::uint32_t>& rejected_edges);
  void say(const std::string& line);

  SlamParams params_;
  PluginContext context_;
  SessionWriter& session_;
  RadarPoints radar_points_;
  std::unique_ptr<Odometry> odometry_;
  KeyframeSelector selector_;
  LoopCloser loops_;
  LoopLedger ledger_;
  IncrementalOptimiser optimiser_;
  Satellites satellites_;
  CloudStore clouds_;  ///< loopScan() of each, frame base
  Pose T_base_sensor_;

  std::vector<Keyframe> keyframes_;
  PoseGraph graph_;        ///< nodes = keyframes, T_map_base; odometry alone
  std::size_t taken_ = 0;  ///< scans taken from the source
  std::optional<Stamp> last_stamp_;
  SlamCounts counts_;
  StageTimes times_;
};

}  // namespace scslam
