// A candidate on trial: registered against the scans around a keyframe, judged by every gate, written into its record.
#pragma once
#include <optional>
#include <vector>

#include "scslam/pipeline/loop_scans.h"
#include "scslam/session/records.h"

namespace scslam {

class LoopTrial {
 public:
  /// @param viewpoint_base where the sensor sits in the base frame.
  LoopTrial(const RegistrationParams& params, const PluginContext& context, const Eigen::Vector3d& viewpoint_base);

  /// The poses moved, or the keyframes are others from here on.
  void forgetTarget() { target_.reset(); }
  /// Takes the scans around keyframe `match` as the target, unless they are.
  /// @param limit only keyframes before it are considered. @param cloud_of loopScan() of each, frame base; called
  /// from several threads.
  void setTarget(KeyframeId match, const std::vector<Keyframe>& keyframes, KeyframeId limit,
                 const std::vector<Pose>& T_map_base, const KeyframeCloud& cloud_of);

  /// What verify() wants of keyframe k (loopQuery()).
  Cloud query(KeyframeId k, const std::vector<Keyframe>& keyframes, KeyframeId limit,
              const std::vector<Pose>& T_map_base, const KeyframeCloud& cloud_of) const {
    return loopQuery(k, keyframes, limit, T_map_base, cloud_of, params_);
  }

  /// Registers `query` (frame base) from the guesses and fills what was measured and the verdict into `record`
  /// (whose query, match and recogniser stay).
  void verify(LoopRecord& record, const Cloud& query, std::vector<Pose> T_match_query_guesses,
              const OdometryPrediction& predicted, bool planar);

 private:
  ThreadPool& threads_;
  RegistrationParams params_;
  LoopVerifier verifier_;
  std::optional<KeyframeId> target_;  ///< what verifier_ holds
};

}  // namespace scslam
