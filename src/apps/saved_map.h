// A saved session made ready to be searched: what merge and localize ask it.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "scslam/graph/consistency.h"
#include "scslam/pipeline/loop_scans.h"
#include "scslam/session/cloud_store.h"
#include "scslam/session/session.h"

namespace scslam {

/// The keyframes of a session that have a scan, numbered anew from 0, in base frames that put the sensor where the
/// caller says: two sessions of differently mounted sensors so speak of the same base, and scans stay as they are.
class SavedMap {
 public:
  /// @param T_base_sensor the sensor in the common base frame (the session's own: nothing changes).
  /// @param registration how scans are thinned for loops. @param cache_bytes of them kept in memory.
  /// @throw inputError when a scan of one of our own sessions is missing (classic folders may have lost some), when
  /// there are no keyframes or a pose is no rigid motion.
  SavedMap(Session session, const Pose& T_base_sensor, const RegistrationParams& registration, std::size_t cache_bytes);

  const Session& session() const { return session_; }
  std::string name() const;              ///< its folder's
  bool rigid() const;                    ///< a surveyed map: its keyframes do not move against each other
  std::filesystem::path origin() const;  ///< its folder, or the file it was made of
  const std::vector<Keyframe>& keyframes() const { return keyframes_; }
  const std::vector<Pose>& poses() const { return T_map_base_; }  ///< per keyframe
  const std::vector<LoopRecord>& loops() const { return loops_; }
  const std::vector<ScanRecord>& scans() const { return scans_; }
  const std::vector<GnssRecord>& gnss() const { return gnss_; }
  std::size_t keyframesWithoutScan() const { return session_.keyframes().size() - keyframes_.size(); }
  /// The common base in the session's own base frame.
  const Pose& T_own_base() const { return T_own_base_; }
  /// Number of keyframe k in the session's own folder.
  KeyframeId ownNumber(KeyframeId k) const { return own_[k]; }

  /// loopScan(), frame base. From several threads.
  std::shared_ptr<const Cloud> cloud(KeyframeId k) const { return clouds_->get(own_[k]); }
  /// Whole, frame base; not kept.
  Cloud wholeCloud(KeyframeId k) const;

  /// Adds the keyframes as nodes where the map has them.
  void addNodesTo(LoopConsistency& consistency) const;

 private:
  void takeKeyframes();
  void takeRecords();

  Session session_;
  Pose T_own_base_;
  Pose T_base_sensor_;
  std::vector<Keyframe> keyframes_;
  std::vector<Pose> T_map_base_;
  std::vector<KeyframeId> own_;
  std::vector<std::int64_t> kept_;  ///< by own number: number here of the newest one kept up to it, -1: none yet
  std::vector<LoopRecord> loops_;
  std::vector<ScanRecord> scans_;
  std::vector<GnssRecord> gnss_;
  std::unique_ptr<CloudStore> clouds_;
};

/// Tells sessions apart wherever they lie: a digest of stamps and poses.
std::string contentDigest(const Session& session);

/// Does keyframe k not follow the one before by odometry (session_graph.h, kOpenStep)?
bool beginsAnew(const Keyframe& keyframe);

/// Layers the configuration a session was made with over `params`; one that this program does not read is left out with
/// a warning.
void loadSessionConfig(ParamSet& params, const Session& session, const PluginContext& context);

}  // namespace scslam
