#include "scslam/registration/free_space.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace scslam {
namespace {

struct Upright {
  VoxelCoord voxel;
  std::size_t patch;
};

bool stacked(const Upright& below, const Upright& above) {
  return below.voxel.x() == above.voxel.x() && below.voxel.y() == above.voxel.y() &&
         below.voxel.z() + 1 == above.voxel.z();
}

/// Marks every stack of at least `least` patches without a gap.
void markWalls(std::vector<Upright> upright, std::size_t least, Patches& patches) {
  std::sort(upright.begin(), upright.end(), [](const Upright& a, const Upright& b) {
    return std::tuple(a.voxel.x(), a.voxel.y(), a.voxel.z()) < std::tuple(b.voxel.x(), b.voxel.y(), b.voxel.z());
  });
  for (std::size_t begin = 0, end = 0; begin < upright.size(); begin = end) {
    for (end = begin + 1; end < upright.size() && stacked(upright[end - 1], upright[end]);) ++end;
    if (end - begin < least) continue;
    for (std::size_t i = begin; i < end; ++i) patches.wall[upright[i].patch] = 1;
  }
}

}  // namespace

Patches patchesOf(const Cloud& cloud, double voxel_m, bool planar) {
  constexpr float kUpright = 0.35f;   // |n_z| below: 20 degrees from the vertical
  constexpr float kThickness = 0.1f;  // of a wall: standard deviation along the normal / voxel
  VoxelSurface surface(voxel_m, SurfelRules::of(planar));
  surface.insert(cloud, Pose::Identity());
  const auto size = static_cast<float>(voxel_m);
  Patches patches;
  std::vector<Upright> upright;
  surface.forEachPlane([&](const VoxelCoord& voxel, const Surfel& s) {
    if (std::abs(s.nz) <= kUpright && s.variance <= kThickness * kThickness * size * size)
      upright.push_back({voxel, patches.points.size()});
    patches.points.push_back(voxel.cast<float>() * size + Eigen::Vector3f(s.mx, s.my, s.mz));
    patches.normals.emplace_back(s.nx, s.ny, s.nz);
    patches.wall.push_back(0);
  });
  markWalls(std::move(upright), planar ? 1 : 3, patches);
  return patches;
}

double patchSize(const Cloud& cloud, bool planar) {
  if (!planar) return 1.0;
  std::vector<float> range2(cloud.size());
  for (std::size_t i = 0; i < range2.size(); ++i) range2[i] = cloud.point(i).squaredNorm();
  std::erase_if(range2, [](float r2) { return !std::isfinite(r2); });
  if (range2.empty()) return 0.3;
  const auto middle = range2.begin() + static_cast<std::ptrdiff_t>(range2.size() / 2);
  std::nth_element(range2.begin(), middle, range2.end());
  return std::clamp(0.1 * std::sqrt(static_cast<double>(*middle)), 0.3, 2.0);
}

SightFigures sightOf(const RangeImage& image, const Patches& patches_b, const Pose& T_a_b, float margin_m) {
  constexpr float kFacing = 0.25f;  // at grazing sight a small error of pose moves the range by much
  const Eigen::Isometry3f T = T_a_b.cast<float>();
  SightFigures figures;
  for (std::size_t i = 0; i < patches_b.points.size(); ++i) {
    const Eigen::Vector3f p = T * patches_b.points[i], ray = p - image.viewpoint();
    const float facing = (T.linear() * patches_b.normals[i]).dot(ray);
    if (std::abs(facing) < kFacing * ray.norm()) continue;
    const Sight sight = image.at(p, margin_m);
    if (sight != Sight::kSurface && sight != Sight::kFree) continue;
    const std::size_t through = sight == Sight::kFree;
    ++figures.seen;
    figures.through += through;
    figures.seen_walls += patches_b.wall[i];
    figures.through_walls += through * patches_b.wall[i];
  }
  return figures;
}

}  // namespace scslam
