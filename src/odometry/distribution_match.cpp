#include "scslam/odometry/distribution_match.h"

#include "scslam/core/voxel_filter.h"

namespace scslam {
namespace {

constexpr int kPlaneLevels = 3;

/// Inverse of a symmetric positive matrix given as xx xy xz yy yz zz.
void invertSymmetric(const float (&C)[6], float (&M)[6]) {
  const float xx = C[3] * C[5] - C[4] * C[4], xy = C[2] * C[4] - C[1] * C[5], xz = C[1] * C[4] - C[2] * C[3];
  const float scale = 1.0f / (C[0] * xx + C[1] * xy + C[2] * xz);
  M[0] = scale * xx, M[1] = scale * xy, M[2] = scale * xz;
  M[3] = scale * (C[0] * C[5] - C[2] * C[2]);
  M[4] = scale * (C[1] * C[2] - C[0] * C[4]);
  M[5] = scale * (C[0] * C[3] - C[1] * C[1]);
}

/// Takes `amount` of variance away along n.
void flatten(float (&C)[6], const Eigen::Vector3f& n, float amount) {
  C[0] -= amount * n.x() * n.x(), C[1] -= amount * n.x() * n.y(), C[2] -= amount * n.x() * n.z();
  C[3] -= amount * n.y() * n.y(), C[4] -= amount * n.y() * n.z(), C[5] -= amount * n.z() * n.z();
}

}  // namespace

PlanarPoints planarPoints(const Cloud& cloud, double voxel_m, double plane_m, const SurfelRules& rules) {
  SurfacePyramid planes(plane_m, kPlaneLevels, rules);
  planes.insert(cloud, Pose::Identity());
  const SurfelFinder finder(planes, {0, kPlaneLevels - 1}, Pose::Identity());
  PlanarPoints points;
  points.cloud = selected(cloud, onePerVoxel(cloud, voxel_m));
  const std::size_t n = points.cloud.size();
  for (auto* field : {&points.nx, &points.ny, &points.nz}) field->assign(n, 0.0f);
  points.variance.assign(n, -1.0f);
  for (std::size_t i = 0; i < n; ++i) {
    Eigen::Vector3f offset;
    const Surfel* plane = finder.find(points.cloud.point(i), offset);
    if (plane == nullptr) continue;
    points.nx[i] = plane->nx, points.ny[i] = plane->ny, points.nz[i] = plane->nz;
    points.variance[i] = plane->variance;
  }
  return points;
}

MatchSystem lineariseDistributions(const SurfacePyramid& map, LevelRange levels, const PlanarPoints& source,
                                   double spread_m, const Pose& T_map_scan, const MatchKernel& kernel,
                                   ThreadPool& threads) {
  const auto sigma2 = static_cast<float>(kernel.sigma_m * kernel.sigma_m);
  const auto spread2 = static_cast<float>(spread_m * spread_m);
  const auto term = [&](std::size_t i, const Surfel& plane, const Eigen::Vector3f& n_map, const Eigen::Vector3f& d,
                        float(&M)[6]) {
    // A point without a plane of its own is taken for what it is: a point.
    const bool has_plane = source.variance[i] >= 0.0f;
    const float along = (has_plane ? 2 : 1) * spread2 + sigma2;
    float C[6] = {along, 0, 0, along, 0, along};
    flatten(C, n_map, std::max(spread2 - plane.variance, 0.0f));
    if (has_plane) flatten(C, {source.nx[i], source.ny[i], source.nz[i]}, std::max(spread2 - source.variance[i], 0.0f));
    invertSymmetric(C, M);
    return std::abs(n_map.dot(d));
  };
  return lineariseTerms(map, levels, source.cloud, T_map_scan, kernel, threads, term);
}

}  // namespace scslam
