// Puts meshes together from the shapes worlds are made of.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "scslam/core/counter_random.h"
#include "sim/mesh.h"

namespace scslam::sim {

class MeshBuilder {
 public:
  /// Triangles added from now on have this material.
  MeshBuilder& material(const std::string& name);
  /// … and belong to a new thing (the next instance number).
  MeshBuilder& newInstance();
  MeshBuilder& noInstance();

  void triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);
  /// Corners counter-clockwise seen from outside.
  void quad(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, const Eigen::Vector3d& d);
  /// Upright box: centre of its bottom, length (along yaw), width, height [m], yaw [rad].
  void box(const Eigen::Vector3d& bottom, double length, double width, double height, double yaw = 0);
  /// Box given by a pose (centre of its bottom) and its size.
  void box(const Pose& T_world_bottom, double length, double width, double height);
  /// Prism: a convex outline (x, z), counter-clockwise seen from -y, from y0 to y1 of the given frame.
  void prism(const Pose& T_world_prism, const std::vector<Eigen::Vector2d>& outline, double y0, double y1);
  /// Surface of rows x columns cells through the points at(0 … rows, 0 … columns), seen from the side of
  /// (step of row) x (step of column).
  void patch(int rows, int columns, const std::function<Eigen::Vector3d(int, int)>& at);
  /// Closed cylinder from a to b.
  void cylinder(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double radius, int sides = 8);
  void sphere(const Eigen::Vector3d& centre, double radius, int rings = 8);
  /// Surface z = height(x, y) over a rectangle, in cells of about `cell_m`, seen from above.
  void terrain(double x0, double y0, double x1, double y1, double cell_m,
               const std::function<double(double, double)>& height);
  /// Leaves: small triangles at random within an ellipsoid, `density` per m^3, of about leaf_m across.
  void foliage(const Eigen::Vector3d& centre, const Eigen::Vector3d& radii, double density, double leaf_m,
               RandomSequence& random);

  std::uint16_t instance() const { return instance_; }
  Mesh& mesh() { return mesh_; }
  Mesh take() { return std::move(mesh_); }

 private:
  Mesh mesh_;
  std::uint16_t material_ = 0, instance_ = 0, instances_ = 0;
};

}  // namespace scslam::sim
