#include "sim/polygon_mesh.h"

#include <Eigen/Geometry>
#include <numeric>

namespace scslam::sim {

using Eigen::Vector3d;

namespace {

/// Newell's: also of polygons with hollow corners.
Vector3d normalOfPolygon(std::span<const Vector3d> polygon) {
  Vector3d n = Vector3d::Zero();
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    n += (polygon[i] - polygon[0]).cross(polygon[i + 1] - polygon[0]);
  return n;
}

/// Seen against n: is p within the triangle or on its edge, but at none of its corners?
bool within(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& n) {
  if (p == a || p == b || p == c) return false;
  const auto left = [&](const Vector3d& from, const Vector3d& to) { return (to - from).cross(p - from).dot(n) >= 0; };
  return left(a, b) && left(b, c) && left(c, a);
}

}  // namespace

std::vector<std::array<std::uint32_t, 3>> cutPolygon(std::span<const Vector3d> polygon) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  if (polygon.size() < 3) return triangles;
  const Vector3d n = normalOfPolygon(polygon);
  std::vector<std::uint32_t> left(polygon.size());
  std::iota(left.begin(), left.end(), 0U);
  std::size_t at = 0, tried = 0;
  while (left.size() > 3) {
    const std::size_t before = (at + left.size() - 1) % left.size(), after = (at + 1) % left.size();
    const Vector3d &a = polygon[left[before]], &b = polygon[left[at]], &c = polygon[left[after]];
    bool ear = (b - a).cross(c - b).dot(n) > 0;
    for (std::size_t i = 0; ear && i < left.size(); ++i)
      ear = i == before || i == at || i == after || !within(polygon[left[i]], a, b, c, n);
    // Without any ear (a polygon that cuts itself, or a line) the next corner has to do.
    if (ear || tried == left.size()) {
      triangles.push_back({left[before], left[at], left[after]});
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(at));
      tried = 0;
    } else {
      ++at, ++tried;
    }
    at %= left.size();
  }
  triangles.push_back({left[0], left[1], left[2]});
  return triangles;
}

}  // namespace scslam::sim
