#include "sim/mesh.h"

namespace scslam::sim {

void Mesh::append(const Mesh& other, const Pose& T_this_other) {
  const auto base = static_cast<std::uint32_t>(vertices.size());
  vertices.reserve(vertices.size() + other.vertices.size());
  for (const Eigen::Vector3f& v : other.vertices) vertices.push_back((T_this_other * v.cast<double>()).cast<float>());
  for (const auto& t : other.triangles) triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  material.insert(material.end(), other.material.begin(), other.material.end());
  instance.insert(instance.end(), other.instance.begin(), other.instance.end());
}

Eigen::AlignedBox3f Mesh::bounds() const {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& v : vertices) box.extend(v);
  return box;
}

}  // namespace scslam::sim
