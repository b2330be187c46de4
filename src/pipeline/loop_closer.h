// Long-term data association (paper, Sec. III-B2): place recognition, registration against a submap, gates.
#pragma once
#include <memory>
#include <vector>

#include "scslam/pipeline/slam_params.h"
#include "scslam/session/cloud_store.h"
#include "scslam/session/records.h"

namespace scslam {

class LoopCloser {
 public:
  LoopCloser(const SlamParams& params, const PluginContext& context);

  Descriptor describe(const Keyframe& keyframe, const Cloud& cloud_base) const {
    return recogniser_->describe(keyframe, cloud_base);
  }
  void add(const Keyframe& keyframe, const Descriptor& descriptor) { recogniser_->add(keyframe, descriptor); }

  /// Every candidate for the newest keyframe with its figures and verdict.
  std::vector<LoopRecord> close(const std::vector<Keyframe>& keyframes, const std::vector<Pose>& T_map_base,
                                CloudStore& clouds);

 private:
  LoopRecord verify(const PlaceCandidate& candidate, const std::vector<Keyframe>& keyframes,
                    const std::vector<Pose>& T_map_base, CloudStore& clouds);

  RegistrationParams params_;
  std::string recogniser_name_;
  std::unique_ptr<PlaceRecogniser> recogniser_;
  std::unique_ptr<Registration> registration_;
};

}  // namespace scslam
