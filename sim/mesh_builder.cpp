#include "sim/mesh_builder.h"

#include <algorithm>
#include <cmath>

#include "sim/material.h"

namespace scslam::sim {

using Eigen::Vector3d;

MeshBuilder& MeshBuilder::material(const std::string& name) {
  material_ = materialIndex(name);
  return *this;
}

MeshBuilder& MeshBuilder::newInstance() {
  instance_ = ++instances_;
  return *this;
}

MeshBuilder& MeshBuilder::noInstance() {
  instance_ = 0;
  return *this;
}

void MeshBuilder::triangle(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const auto base = static_cast<std::uint32_t>(mesh_.vertices.size());
  for (const Vector3d& v : {a, b, c}) mesh_.vertices.push_back(v.cast<float>());
  mesh_.triangles.push_back({base, base + 1, base + 2});
  mesh_.material.push_back(material_);
  mesh_.instance.push_back(instance_);
}

void MeshBuilder::quad(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  const auto base = static_cast<std::uint32_t>(mesh_.vertices.size());
  for (const Vector3d& v : {a, b, c, d}) mesh_.vertices.push_back(v.cast<float>());
  mesh_.triangles.push_back({base, base + 1, base + 2});
  mesh_.triangles.push_back({base, base + 2, base + 3});
  mesh_.material.insert(mesh_.material.end(), 2, material_);
  mesh_.instance.insert(mesh_.instance.end(), 2, instance_);
}

void MeshBuilder::box(const Vector3d& bottom, double length, double width, double height, double yaw) {
  box(poseFromYaw(yaw, bottom), length, width, height);
}

void MeshBuilder::box(const Pose& T_world_bottom, double length, double width, double height) {
  const double x = length / 2, y = width / 2, z = height;
  const auto p = [&](double sx, double sy, double sz) { return Vector3d(T_world_bottom * Vector3d(sx, sy, sz)); };
  quad(p(-x, -y, 0), p(-x, y, 0), p(x, y, 0), p(x, -y, 0));
  quad(p(-x, -y, z), p(x, -y, z), p(x, y, z), p(-x, y, z));
  quad(p(-x, -y, 0), p(x, -y, 0), p(x, -y, z), p(-x, -y, z));
  quad(p(x, y, 0), p(-x, y, 0), p(-x, y, z), p(x, y, z));
  quad(p(x, -y, 0), p(x, y, 0), p(x, y, z), p(x, -y, z));
  quad(p(-x, y, 0), p(-x, -y, 0), p(-x, -y, z), p(-x, y, z));
}

void MeshBuilder::prism(const Pose& T_world_prism, const std::vector<Eigen::Vector2d>& outline, double y0, double y1) {
  const auto p = [&](std::size_t k, double y) {
    const Eigen::Vector2d& corner = outline[k % outline.size()];
    return Vector3d(T_world_prism * Vector3d(corner.x(), y, corner.y()));
  };
  for (std::size_t k = 0; k < outline.size(); ++k) quad(p(k, y0), p(k, y1), p(k + 1, y1), p(k + 1, y0));
  for (std::size_t k = 1; k + 1 < outline.size(); ++k) {
    triangle(p(0, y0), p(k, y0), p(k + 1, y0));
    triangle(p(0, y1), p(k + 1, y1), p(k, y1));
  }
}

void MeshBuilder::cylinder(const Vector3d& a, const Vector3d& b, double radius, int sides) {
  const Vector3d axis = (b - a).normalized();
  const Vector3d u = axis.unitOrthogonal() * radius, v = axis.cross(u);
  const auto rim = [&](int k) {
    const double angle = 2 * M_PI * k / sides;
    return Vector3d(u * std::cos(angle) + v * std::sin(angle));
  };
  for (int k = 0; k < sides; ++k) {
    const Vector3d p = rim(k), q = rim((k + 1) % sides);
    quad(a + p, a + q, b + q, b + p);
    triangle(a, a + q, a + p);
    triangle(b, b + p, b + q);
  }
}

void MeshBuilder::sphere(const Vector3d& centre, double radius, int rings) {
  const int sides = 2 * rings;
  const auto at = [&](int i, int k) {
    const double polar = M_PI * i / rings, azimuth = 2 * M_PI * (k % sides) / sides;
    return Vector3d(centre + radius * Vector3d(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth),
                                               std::cos(polar)));
  };
  for (int i = 0; i < rings; ++i)
    for (int k = 0; k < sides; ++k) {
      if (i > 0) triangle(at(i, k), at(i + 1, k), at(i, k + 1));
      if (i + 1 < rings) triangle(at(i, k + 1), at(i + 1, k), at(i + 1, k + 1));
    }
}

void MeshBuilder::terrain(double x0, double y0, double x1, double y1, double cell_m,
                          const std::function<double(double, double)>& height,
                          const std::function<bool(double, double)>& where) {
  const int nx = std::max(1, static_cast<int>(std::lround((x1 - x0) / cell_m)));
  const int ny = std::max(1, static_cast<int>(std::lround((y1 - y0) / cell_m)));
  const auto x = [&](double i) { return x0 + (x1 - x0) * i / nx; };
  const auto y = [&](double j) { return y0 + (y1 - y0) * j / ny; };
  const auto at = [&](int i, int j) { return Vector3d(x(i), y(j), height(x(i), y(j))); };
  if (where)
    patch(nx, ny, at, [&](int i, int j) { return where(x(i + 0.5), y(j + 0.5)); });
  else
    patch(nx, ny, at);
}

void MeshBuilder::patch(int rows, int columns, const std::function<Vector3d(int, int)>& at,
                        const std::function<bool(int, int)>& where) {
  constexpr std::uint32_t kNone = 0xFFFFFFFF;
  std::vector<std::uint32_t> index(static_cast<std::size_t>(rows + 1) * static_cast<std::size_t>(columns + 1), kNone);
  const auto vertex = [&](int i, int j) {
    std::uint32_t& k =
        index[static_cast<std::size_t>(i) * static_cast<std::size_t>(columns + 1) + static_cast<std::size_t>(j)];
    if (k == kNone) {
      k = static_cast<std::uint32_t>(mesh_.vertices.size());
      mesh_.vertices.push_back(at(i, j).cast<float>());
    }
    return k;
  };
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) {
      if (where && !where(i, j)) continue;
      const std::uint32_t a = vertex(i, j), b = vertex(i + 1, j), c = vertex(i + 1, j + 1), d = vertex(i, j + 1);
      mesh_.triangles.push_back({a, b, c});
      mesh_.triangles.push_back({a, c, d});
      mesh_.material.insert(mesh_.material.end(), 2, material_);
      mesh_.instance.insert(mesh_.instance.end(), 2, instance_);
    }
}

void MeshBuilder::foliage(const Vector3d& centre, const Vector3d& radii, double density, double leaf_m,
                          RandomSequence& random) {
  const double volume = 4.0 / 3.0 * M_PI * radii.prod();
  const int leaves = static_cast<int>(volume * density);
  const auto direction = [&random] {
    Vector3d d(0, 0, 0);
    for (double& x : d) x = std::clamp(random.normal(), -6.0, 6.0);
    return Vector3d(d / std::max(1e-9, d.norm()));
  };
  for (int i = 0; i < leaves; ++i) {
    // Denser towards the outside, as leaves are.
    const Vector3d p = centre + radii.cwiseProduct(direction()) * std::pow(random.uniform(), 0.25);
    const Vector3d u = direction(), v = u.cross(direction()).normalized();
    const double size = leaf_m * random.uniform(0.6, 1.4);
    triangle(p, p + u * size, p + (u + v * 1.7) * size / 2);
  }
}

}  // namespace scslam::sim
