#include "scslam/apps/place_recognition_truth.h"

#include <cmath>
#include <map>
#include <utility>

namespace scslam {

std::vector<std::optional<NearestPlace>> nearestPlaces(const std::vector<Keyframe>& keyframes,
                                                       const std::vector<std::optional<Pose>>& T_truth_base,
                                                       double reach_m, double min_travel_m) {
  using Cell = std::pair<std::int64_t, std::int64_t>;
  std::map<Cell, std::vector<std::size_t>> cells;
  const double side = std::max(reach_m, 1e-3);
  const auto cellOf = [side](const Eigen::Vector3d& p) {
    return Cell(std::llround(std::floor(p.x() / side)), std::llround(std::floor(p.y() / side)));
  };
  std::vector<std::optional<NearestPlace>> nearest(keyframes.size());
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    if (!T_truth_base[k]) continue;
    const Cell home = cellOf(T_truth_base[k]->translation());
    for (std::int64_t dx = -1; dx <= 1; ++dx)
      for (std::int64_t dy = -1; dy <= 1; ++dy) {
        const auto found = cells.find({home.first + dx, home.second + dy});
        if (found == cells.end()) continue;
        for (const std::size_t earlier : found->second) {
          if (keyframes[k].travelled_m - keyframes[earlier].travelled_m < min_travel_m) continue;
          const Pose T_match_query = T_truth_base[earlier]->inverse() * *T_truth_base[k];
          const double distance = T_match_query.translation().norm();
          if (distance > reach_m || (nearest[k] && nearest[k]->distance_m <= distance)) continue;
          nearest[k] = {static_cast<KeyframeId>(earlier), distance, std::abs(yawOf(T_match_query)) * 180 / M_PI,
                        std::abs(T_match_query.translation().y())};
        }
      }
    cells[home].push_back(k);
  }
  return nearest;
}

}  // namespace scslam
