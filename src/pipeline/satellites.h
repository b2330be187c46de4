// Satellite fixes on their way into the graph.
#pragma once
#include <vector>

#include "scslam/core/bytes.h"
#include "scslam/pipeline/slam_params.h"
#include "scslam/session/records.h"

namespace scslam {

/// Ties each fix to the keyframe before it, by the odometry at the fix's own time.
class Satellites {
 public:
  explicit Satellites(const GnssParams& params) : params_(params) {}

  /// Takes the fixes that came with a scan. @param T_odom_base at the scan's stamp. @param newest keyframe, if any.
  /// @return records of the fixes between the scan before and this one that count: at most one a keyframe.
  std::vector<GnssRecord> take(const Scan& scan, const Pose& T_odom_base, const Keyframe* newest);
  /// A record of take() or of a session that goes on.
  void add(const GnssRecord& record);
  /// Are there so many new fixes that the graph should be solved?
  bool due() const {
    return params_.enabled && records_.size() >= solved_ + static_cast<std::size_t>(params_.solve_every);
  }
  bool anyNew() const { return params_.enabled && records_.size() > solved_; }
  /// Adds the satellites' frame as a last node of the graph and a position factor for each fix, where there are enough
  /// to place that frame. @param graph its poses are the keyframes'.
  void appendTo(PoseGraph& graph);

  void save(ByteWriter& state) const;
  void load(ByteReader& state);

 private:
  GnssParams params_;
  std::vector<GnssFix> waiting_;  ///< later than the newest scan
  bool has_scan_ = false;
  Stamp last_stamp_;
  Pose T_odom_base_ = Pose::Identity();  ///< at last_stamp_
  std::vector<GnssRecord> records_;
  std::size_t solved_ = 0;  ///< records that were in the graph when it was last solved
};

}  // namespace scslam
