// The scans that can testify about another one, made ready and kept within a budget of memory.
#pragma once
#include <map>
#include <memory>
#include <vector>

#include "scslam/apps/clean/clean.h"
#include "scslam/apps/clean/ground_cells.h"
#include "scslam/apps/clean/sight_image.h"
#include "scslam/apps/saved_map.h"

namespace scslam {

/// What is kept of a scan that testifies.
struct View {
  Pose T_map_sensor;
  SightImage image;
  std::vector<LowPoint> low_points;
};

class Views {
 public:
  /// @param map, params outlive this.
  Views(const SavedMap& map, const CleanParams& params);

  /// Keyframes whose scans testify about keyframe k, of those within reach, increasing.
  struct Around {
    std::vector<KeyframeId> soon;   ///< taken just before and after it
    std::vector<KeyframeId> later;  ///< of the others, evenly spread over time
  };
  Around around(KeyframeId k) const;
  /// Makes all that are needed for the keyframes begin .. end and forgets the ones used longest ago beyond the budget.
  void prepare(KeyframeId begin, KeyframeId end, const PluginContext& context);
  /// A prepared one.
  const View& at(KeyframeId k) const { return *views_.at(k).view; }

  const SightGrid& grid() const { return grid_; }
  Pose T_map_sensor(KeyframeId k) const { return map_.poses()[k] * T_base_sensor_; }

 private:
  struct Kept {
    std::unique_ptr<View> view;
    KeyframeId last_use = 0;
  };
  View make(KeyframeId k) const;
  void forget();

  const SavedMap& map_;
  Pose T_base_sensor_;
  const CleanParams& params_;
  SightGrid grid_;
  std::map<KeyframeId, Kept> views_;
};

/// Scan of keyframe k as the session has it, frame sensor.
Cloud scanOf(const SavedMap& map, KeyframeId k);

}  // namespace scslam
