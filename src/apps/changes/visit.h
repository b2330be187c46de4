// One visit of a merged session, voxel by voxel, and what another visit says of each.
#pragma once
#include <functional>
#include <vector>

#include "scslam/apps/changes/changes.h"
#include "scslam/apps/clean/views.h"

namespace scslam {

class Visit {
 public:
  /// @param map outlives this. @param keyframes of the visit.
  Visit(const SavedMap& map, std::vector<KeyframeId> keyframes, const ChangeParams& params);

  /// Holds all scans against the other visit's. @param progress called with the keyframes done; may throw to end.
  void compare(Visit& other, const PluginContext& context, const std::function<void(std::size_t)>& progress);

  /// Appends one point per voxel to the map; what the other visit looked through counts as `change`, where it hangs
  /// together, and is appended to things.
  void report(Change change, ChangeMap& map, std::vector<ChangedThing>& things) const;

  const std::vector<KeyframeId>& keyframes() const { return keyframes_; }
  std::uint64_t movingPoints() const { return moving_points_; }

 private:
  struct Voxel {
    Eigen::Vector3f first = Eigen::Vector3f::Zero();  ///< point in it
    std::uint32_t free = 0, surface = 0;              ///< the other visit's votes
    std::uint32_t points = 0, moving = 0;             ///< of this visit's own
  };
  struct Judged {
    Cloud cloud_map;
    SightVotes other{0};
    std::vector<std::uint8_t> moving;
  };
  std::vector<KeyframeId> around(const Eigen::Vector3d& p_map) const;
  std::vector<KeyframeId> soon(std::size_t at) const;
  Judged judge(KeyframeId k, const std::vector<KeyframeId>& own, const Visit& other,
               const std::vector<KeyframeId>& others) const;
  void add(const Judged& judged);
  std::vector<std::vector<std::uint32_t>> looseThings() const;
  bool lookedThrough(const Voxel& voxel) const;

  const SavedMap& map_;
  std::vector<KeyframeId> keyframes_;
  const ChangeParams& params_;
  Views views_;
  VoxelIndex index_;
  std::vector<Voxel> voxels_;
  std::uint64_t moving_points_ = 0;
};

}  // namespace scslam
