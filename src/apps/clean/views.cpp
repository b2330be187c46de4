#include "scslam/apps/clean/views.h"

#include <algorithm>
#include <iterator>
#include <set>

#include "scslam/core/parallel.h"

namespace scslam {
namespace {

/// Scans from which the grid of directions is made, evenly spread over the session.
constexpr std::size_t kSamples = 24;

}  // namespace

Cloud scanOf(const SavedMap& map, KeyframeId k) { return map.session().cloud(map.ownNumber(k)); }

Views::Views(const SavedMap& map, const CleanParams& params)
    : map_(map), T_base_sensor_(map.session().info().T_base_sensor), params_(params) {
  std::vector<Cloud> samples;
  const std::size_t n = map.keyframes().size(), step = std::max<std::size_t>(1, n / kSamples);
  for (std::size_t k = 0; k < n; k += step) samples.push_back(scanOf(map, static_cast<KeyframeId>(k)));
  grid_ = sightGridOf(samples, map.session().info().planar);
}

Views::Around Views::around(KeyframeId k) const {
  Around around;
  const auto soon = static_cast<KeyframeId>(params_.soon_views / 2);
  const Eigen::Vector3d here = map_.poses()[k].translation();
  for (KeyframeId other = 0; other < map_.keyframes().size(); ++other) {
    if (other == k || (map_.poses()[other].translation() - here).norm() > params_.reach_m) continue;
    (std::max(k, other) - std::min(k, other) <= soon ? around.soon : around.later).push_back(other);
  }
  const auto most = static_cast<std::size_t>(params_.later_views);
  if (around.later.size() <= most) return around;
  std::vector<KeyframeId> spread;
  for (std::size_t i = 0; i < most; ++i) spread.push_back(around.later[i * around.later.size() / most]);
  around.later = std::move(spread);
  return around;
}

View Views::make(KeyframeId k) const {
  const Pose T = T_map_sensor(k);
  const Cloud cloud = scanOf(map_, k);
  return {T, SightImage(cloud, grid_), lowPoints(transformed(cloud, T), T.translation().cast<float>())};
}

void Views::prepare(KeyframeId begin, KeyframeId end, const PluginContext& context) {
  std::set<KeyframeId> needed;
  for (KeyframeId k = begin; k < end; ++k) {
    needed.insert(k);
    const Around views = around(k);
    needed.insert(views.soon.begin(), views.soon.end());
    needed.insert(views.later.begin(), views.later.end());
  }
  std::vector<KeyframeId> missing;
  for (const KeyframeId k : needed) {
    Kept& kept = views_[k];
    kept.last_use = end;
    if (!kept.view) missing.push_back(k);
  }
  context.threads.forEachChunk(missing.size(), 1, [&](std::size_t i, std::size_t, std::size_t) {
    views_.at(missing[i]).view = std::make_unique<View>(make(missing[i]));
  });
  forget();
}

void Views::forget() {
  const double budget_bytes = params_.cache_mb * 1e6;
  std::size_t bytes = 0;
  KeyframeId newest = 0;
  std::vector<std::pair<KeyframeId, KeyframeId>> by_use;
  for (const auto& [k, kept] : views_) {
    bytes += kept.view->image.bytes() + kept.view->low_points.size() * sizeof(LowPoint);
    by_use.emplace_back(kept.last_use, k);
    newest = std::max(newest, kept.last_use);
  }
  std::sort(by_use.begin(), by_use.end());
  for (const auto& [last_use, k] : by_use) {
    if (static_cast<double>(bytes) <= budget_bytes || last_use == newest) return;
    const View& view = *views_.at(k).view;
    bytes -= view.image.bytes() + view.low_points.size() * sizeof(LowPoint);
    views_.erase(k);
  }
}

}  // namespace scslam
