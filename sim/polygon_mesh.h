// Faces with any number of corners, as files hold them, before they are triangles.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace scslam::sim {

struct PolygonMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::uint32_t> corners;  ///< of all faces in a row; may point to vertices that do not exist
  std::vector<std::size_t> face_end;   ///< face i has the corners [face_end[i - 1], face_end[i])

  std::size_t faces() const { return face_end.size(); }
  std::span<const std::uint32_t> face(std::size_t i) const {
    const std::size_t begin = i == 0 ? 0 : face_end[i - 1];
    return {corners.data() + begin, face_end[i] - begin};
  }
};

/// Triangles, as indices into `polygon`, that fill a simple polygon of finite corners, convex or not, nearly flat.
/// Always polygon.size() - 2 of them, in the polygon's sense of rotation; of one that cuts itself they are some
/// triangles. By cutting off ears, about the square of the number of corners.
std::vector<std::array<std::uint32_t, 3>> cutPolygon(std::span<const Eigen::Vector3d> polygon);

}  // namespace scslam::sim
