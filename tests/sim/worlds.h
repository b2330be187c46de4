// What the tests of worlds share.
#pragma once
#include <cmath>
#include <string>
#include <vector>

#include "sim/ray_scene.h"
#include "sim/world_generator.h"
#include "support/support.h"

namespace scslam::sim {

using Eigen::Vector3d;
using Generators = Registry<WorldGenerator>;
constexpr double kSensor = 1.7;  // height of the sensor above the route [m]

inline World make(const std::string& name, const std::vector<std::string>& settings = {}, std::uint64_t seed = 1) {
  auto params = Generators::instance().find(name).defaults();
  for (const std::string& setting : settings) setParam(*params, setting);
  return Generators::instance().create(name, *params, test::context())->generate(seed);
}

inline void expectSound(const Mesh& mesh) {
  ASSERT_FALSE(mesh.empty());
  ASSERT_EQ(mesh.material.size(), mesh.size());
  ASSERT_EQ(mesh.instance.size(), mesh.size());
  for (const Eigen::Vector3f& v : mesh.vertices) ASSERT_TRUE(v.allFinite());
  for (std::size_t i = 0; i < mesh.size(); ++i) {
    ASSERT_LT(mesh.material[i], materials().size());
    for (const std::uint32_t k : mesh.triangles[i]) ASSERT_LT(k, mesh.vertices.size());
    const auto p = [&](std::size_t k) { return Vector3d(mesh.vertices[mesh.triangles[i][k]].cast<double>()); };
    ASSERT_GT((p(1) - p(0)).cross(p(2) - p(0)).norm() / 2, 1e-7)
        << "triangle " << i << " of " << materials()[mesh.material[i]].name << " at " << p(0).transpose() << " | "
        << p(1).transpose() << " | " << p(2).transpose();
  }
}

/// Points of a route every metre.
inline std::vector<Vector3d> pointsAlong(const Route& route) {
  std::vector<Vector3d> corners = route.points, result;
  if (route.closed) corners.push_back(corners.front());
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const int n = std::max(1, static_cast<int>(std::ceil((corners[i + 1] - corners[i]).norm())));
    for (int k = 0; k < n; ++k) result.push_back(corners[i] + (corners[i + 1] - corners[i]) * k / n);
  }
  result.push_back(corners.back());
  return result;
}

/// Nearest thing around a point, level, in 16 directions [m].
inline double clearance(const RayScene& scene, const Vector3d& sensor) {
  double nearest = 100;
  for (int k = 0; k < 16; ++k) {
    const double angle = 2 * M_PI * k / 16;
    const auto hit = scene.first(sensor, {std::cos(angle), std::sin(angle), 0}, 100);
    if (hit) nearest = std::min(nearest, hit->range);
  }
  return nearest;
}

}  // namespace scslam::sim
