// Long-term data association (paper, Sec. III-B2): place recognition, registration against a submap, gates.
#pragma once
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "scslam/pipeline/loop_trial.h"
#include "scslam/session/cloud_store.h"
#include "scslam/session/records.h"

namespace scslam {

class LoopCloser {
 public:
  LoopCloser(const SlamParams& params, const PluginContext& context, const Pose& T_base_sensor);

  /// By the first recogniser: what the session keeps.
  Descriptor describe(const Keyframe& keyframe, const Cloud& cloud_base) const;
  /// @param descriptor the first recogniser's; others describe the scan as `clouds` has it, so that a resumed run gets
  /// the same.
  void add(const Keyframe& keyframe, const Descriptor& descriptor, CloudStore& clouds);

  /// Every candidate for keyframe `query` with its figures and verdict. Pairs that were registered before are left out.
  std::vector<LoopRecord> close(KeyframeId query, const std::vector<Keyframe>& keyframes,
                                const std::vector<Pose>& T_map_base, CloudStore& clouds);
  /// A record of a session that goes on.
  void restore(const LoopRecord& record);

 private:
  /// T_match_query, its covariance along the odometry chain (frame query), the distance travelled between.
  OdometryPrediction predict(const std::vector<Keyframe>& keyframes, const std::vector<Pose>& T_map_base,
                             KeyframeId match, KeyframeId query) const;
  LoopRecord verify(const std::string& recogniser, const PlaceCandidate& candidate, const Keyframe& query,
                    const std::vector<Keyframe>& keyframes, const std::vector<Pose>& T_map_base, CloudStore& clouds);

  LoopGateParams gates_;
  std::vector<std::string> names_;  ///< of the recognisers
  std::vector<std::unique_ptr<PlaceRecogniser>> recognisers_;
  std::vector<Matrix6d> drift_;                             ///< covariance of the chain up to each keyframe, frame odom
  std::vector<int> losses_;                                 ///< steps up to each keyframe that were not followed
  LoopTrial trial_;                                         ///< within one close() the poses stay
  std::optional<Cloud> query_;                              ///< of this close(), once it is needed
  std::set<std::pair<KeyframeId, KeyframeId>> registered_;  ///< query, match; before this close()
};

}  // namespace scslam
