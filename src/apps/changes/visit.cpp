#include "scslam/apps/changes/visit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scslam/core/parallel.h"

namespace scslam {
namespace {

constexpr std::size_t kBatch = 8;  ///< keyframes judged side by side

SightMargins marginsOf(const ChangeParams& params) {
  return {static_cast<float>(params.margin_m), static_cast<float>(params.margin_per_m), 1, 0};
}

}  // namespace

Visit::Visit(const SavedMap& map, std::vector<KeyframeId> keyframes, const ChangeParams& params)
    : map_(map), keyframes_(std::move(keyframes)), params_(params), views_(map, keyframes_, 0.5e6 * params.cache_mb) {}

/// Keyframes within reach, evenly spread.
std::vector<KeyframeId> Visit::around(const Eigen::Vector3d& p_map) const {
  std::vector<KeyframeId> near;
  for (const KeyframeId k : keyframes_)
    if ((map_.poses()[k].translation() - p_map).norm() <= params_.reach_m) near.push_back(k);
  return evenlySpread(near, static_cast<std::size_t>(params_.views));
}

/// Of the same visit, just before and after its keyframe number `at`.
std::vector<KeyframeId> Visit::soon(std::size_t at) const {
  const std::size_t half = static_cast<std::size_t>(params_.own_views) / 2;
  std::vector<KeyframeId> ids;
  for (std::size_t i = at > half ? at - half : 0; i < std::min(keyframes_.size(), at + half + 1); ++i)
    if (i != at) ids.push_back(keyframes_[i]);
  return ids;
}

void Visit::compare(Visit& other, const PluginContext& context, const std::function<void(std::size_t)>& progress) {
  for (std::size_t begin = 0; begin < keyframes_.size(); begin += kBatch) {
    const std::size_t n = std::min(kBatch, keyframes_.size() - begin);
    progress(begin);
    std::vector<std::vector<KeyframeId>> own(n), others(n);
    std::set<KeyframeId> own_needed, others_needed;
    for (std::size_t i = 0; i < n; ++i) {
      own[i] = soon(begin + i);
      others[i] = other.around(map_.poses()[keyframes_[begin + i]].translation());
      own_needed.insert(own[i].begin(), own[i].end());
      others_needed.insert(others[i].begin(), others[i].end());
    }
    views_.prepare(own_needed, context);
    other.views_.prepare(others_needed, context);
    std::vector<Judged> judged(n);
    context.threads.forEachChunk(n, 1, [&](std::size_t i, std::size_t, std::size_t) {
      judged[i] = judge(keyframes_[begin + i], own[i], other, others[i]);
    });
    for (const Judged& scan : judged) add(scan);
  }
}

Visit::Judged Visit::judge(KeyframeId k, const std::vector<KeyframeId>& own, const Visit& other,
                           const std::vector<KeyframeId>& others) const {
  const Cloud cloud = scanOf(map_, k);
  const Pose T_map_sensor = views_.T_map_sensor(k);
  Judged judged{transformed(cloud, T_map_sensor), other.views_.ask(others, cloud, T_map_sensor, marginsOf(params_)),
                std::vector<std::uint8_t>(cloud.size())};
  const SightVotes here = views_.ask(own, cloud, T_map_sensor, marginsOf(params_));
  for (std::size_t i = 0; i < cloud.size(); ++i) judged.moving[i] = here.free[i] > 1 && here.free[i] > here.surface[i];
  return judged;
}

void Visit::add(const Judged& judged) {
  const Cloud& cloud = judged.cloud_map;
  const auto voxel_m = static_cast<float>(params_.voxel_m);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f p = cloud.point(i);
    if (!p.allFinite()) continue;
    const std::uint32_t at = index_.findOrInsert(
        packVoxel(floorToInt(p.x() / voxel_m), floorToInt(p.y() / voxel_m), floorToInt(p.z() / voxel_m)));
    if (at == voxels_.size()) voxels_.push_back({p});
    Voxel& voxel = voxels_[at];
    ++voxel.points;
    voxel.moving += judged.moving[i], moving_points_ += judged.moving[i];
    voxel.free += judged.other.free[i], voxel.surface += judged.other.surface[i];
  }
}

bool Visit::lookedThrough(const Voxel& voxel) const {
  return 2 * voxel.moving <= voxel.points && voxel.free >= static_cast<std::uint32_t>(params_.min_free) &&
         voxel.free > params_.free_share * (voxel.free + voxel.surface);
}

/// Voxels that were looked through and lie no further apart than gap_m, as groups, with what nobody else saw of them.
std::vector<std::vector<std::uint32_t>> Visit::looseThings() const {
  const int reach = std::max(1, static_cast<int>(std::lround(params_.gap_m / params_.voxel_m)));
  std::vector<std::uint8_t> reached(voxels_.size());
  std::vector<std::vector<std::uint32_t>> things;
  for (std::uint32_t first = 0; first < voxels_.size(); ++first) {
    if (reached[first] != 0 || !lookedThrough(voxels_[first])) continue;
    std::vector<std::uint32_t> thing = {first};
    reached[first] = 1;
    for (std::size_t next = 0; next < thing.size(); ++next) {
      if (!lookedThrough(voxels_[thing[next]])) continue;  // what nobody else saw does not lead further
      const VoxelCoord at = unpackVoxel(index_.keys()[thing[next]]);
      for (int z = -reach; z <= reach; ++z)
        for (int y = -reach; y <= reach; ++y)
          for (int x = -reach; x <= reach; ++x) {
            const std::uint32_t beside = index_.find(packVoxel(at + VoxelCoord(x, y, z)));
            if (beside == VoxelIndex::kAbsent || reached[beside] != 0) continue;
            const Voxel& voxel = voxels_[beside];
            if (!lookedThrough(voxel) && (voxel.surface > 0 || 2 * voxel.moving > voxel.points)) continue;
            reached[beside] = 1;
            thing.push_back(beside);
          }
    }
    things.push_back(std::move(thing));
  }
  return things;
}

void Visit::report(Change change, ChangeMap& map, std::vector<ChangedThing>& things) const {
  std::vector<Change> of(voxels_.size());
  for (std::size_t i = 0; i < voxels_.size(); ++i)
    of[i] = voxels_[i].surface + voxels_[i].free > 0 ? Change::kStayed : Change::kUnseen;
  for (const std::vector<std::uint32_t>& thing : looseThings()) {
    const auto sure = std::count_if(thing.begin(), thing.end(), [this](auto i) { return lookedThrough(voxels_[i]); });
    if (sure < params_.min_voxels) continue;
    ChangedThing found{change, voxels_[thing.front()].first, voxels_[thing.front()].first, thing.size()};
    for (const std::uint32_t i : thing) {
      of[i] = change;
      found.low = found.low.cwiseMin(voxels_[i].first), found.high = found.high.cwiseMax(voxels_[i].first);
    }
    things.push_back(found);
  }
  for (std::size_t i = 0; i < voxels_.size(); ++i) {
    if (2 * voxels_[i].moving > voxels_[i].points) continue;
    const Eigen::Vector3f& p = voxels_[i].first;
    map.cloud_map.push(p.x(), p.y(), p.z());
    map.change.push_back(of[i]);
  }
}

}  // namespace scslam
