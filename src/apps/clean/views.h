// Scans that can testify about others, made ready and kept within a budget of memory.
#pragma once
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "scslam/apps/clean/sight_image.h"
#include "scslam/apps/ground_cells.h"
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
  /// @param map outlives this. @param keyframes whose scans can be asked for: those of one sensor.
  /// @param budget_bytes of views kept from one prepare() to the next.
  Views(const SavedMap& map, const std::vector<KeyframeId>& keyframes, double budget_bytes);

  /// Makes those that are missing and forgets others, used longest ago, beyond the budget.
  void prepare(const std::set<KeyframeId>& keyframes, const PluginContext& context);
  /// A prepared one.
  const View& at(KeyframeId k) const { return *views_.at(k).view; }
  /// What the scans of these keyframes, prepared ones, say of a cloud. @param T_map_cloud where it was measured.
  SightVotes ask(const std::vector<KeyframeId>& keyframes, const Cloud& cloud, const Pose& T_map_cloud,
                 const SightMargins& margins) const;

  const SightGrid& grid() const { return grid_; }
  Pose T_map_sensor(KeyframeId k) const { return map_.poses()[k] * T_base_sensor_; }

 private:
  struct Kept {
    std::unique_ptr<View> view;
    std::size_t last_use = 0;
  };
  View make(KeyframeId k) const;
  void forget();

  const SavedMap& map_;
  Pose T_base_sensor_;
  double budget_bytes_;
  SightGrid grid_;
  std::size_t uses_ = 0;
  std::map<KeyframeId, Kept> views_;
};

/// Scan of keyframe k as the session has it, frame sensor.
Cloud scanOf(const SavedMap& map, KeyframeId k);

/// So many of them at most, evenly spread over their order.
std::vector<KeyframeId> evenlySpread(const std::vector<KeyframeId>& keyframes, std::size_t most);

}  // namespace scslam
