#include "scslam/apps/clean/views.h"

#include <algorithm>
#include <tuple>

#include "scslam/core/parallel.h"

namespace scslam {
namespace {

/// Scans from which the grid of directions is made, evenly spread over the session.
constexpr std::size_t kSamples = 24;

std::size_t bytesOf(const View& view) { return view.image.bytes() + view.low_points.size() * sizeof(LowPoint); }

}  // namespace

Cloud scanOf(const SavedMap& map, KeyframeId k) { return map.session().cloud(map.ownNumber(k)); }

std::vector<KeyframeId> evenlySpread(const std::vector<KeyframeId>& keyframes, std::size_t most) {
  if (keyframes.size() <= most) return keyframes;
  std::vector<KeyframeId> spread;
  for (std::size_t i = 0; i < most; ++i) spread.push_back(keyframes[i * keyframes.size() / most]);
  return spread;
}

Views::Views(const SavedMap& map, const std::vector<KeyframeId>& keyframes, double budget_bytes)
    : map_(map), T_base_sensor_(map.session().info().T_base_sensor), budget_bytes_(budget_bytes) {
  std::vector<Cloud> samples;
  for (const KeyframeId k : evenlySpread(keyframes, kSamples)) samples.push_back(scanOf(map, k));
  grid_ = sightGridOf(samples, map.session().info().planar);
}

View Views::make(KeyframeId k) const {
  const Pose T = T_map_sensor(k);
  const Cloud cloud = scanOf(map_, k);
  return {T, SightImage(cloud, grid_), lowPoints(transformed(cloud, T), T.translation().cast<float>())};
}

void Views::prepare(const std::set<KeyframeId>& keyframes, const PluginContext& context) {
  ++uses_;
  std::vector<KeyframeId> missing;
  for (const KeyframeId k : keyframes) {
    Kept& kept = views_[k];
    kept.last_use = uses_;
    if (!kept.view) missing.push_back(k);
  }
  context.threads.forEachChunk(missing.size(), 1, [&](std::size_t i, std::size_t, std::size_t) {
    views_.at(missing[i]).view = std::make_unique<View>(make(missing[i]));
  });
  forget();
}

void Views::forget() {
  double bytes = 0;
  std::vector<std::tuple<std::size_t, KeyframeId>> by_use;
  for (const auto& [k, kept] : views_) {
    bytes += static_cast<double>(bytesOf(*kept.view));
    by_use.emplace_back(kept.last_use, k);
  }
  std::sort(by_use.begin(), by_use.end());
  for (const auto& [last_use, k] : by_use) {
    if (bytes <= budget_bytes_ || last_use == uses_) return;
    bytes -= static_cast<double>(bytesOf(*views_.at(k).view));
    views_.erase(k);
  }
}

SightVotes Views::ask(const std::vector<KeyframeId>& keyframes, const Cloud& cloud, const Pose& T_map_cloud,
                      const SightMargins& margins) const {
  SightVotes votes(cloud.size());
  for (const KeyframeId k : keyframes) {
    const View& view = at(k);
    view.image.vote(cloud, view.T_map_sensor.inverse() * T_map_cloud, grid_, margins, votes);
  }
  return votes;
}

}  // namespace scslam
