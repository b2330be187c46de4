// Triangles with a material and an instance each.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "scslam/core/pose.h"

namespace scslam::sim {

struct Mesh {
  std::vector<Eigen::Vector3f> vertices;                ///< [m], z up
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise seen from outside
  std::vector<std::uint16_t> material;                  ///< per triangle, index into materials()
  std::vector<std::uint16_t> instance;                  ///< per triangle: which thing of its class; 0 = none

  std::size_t size() const { return triangles.size(); }
  bool empty() const { return triangles.empty(); }
  /// Adds another mesh, moved by T_this_other. Instances are kept.
  void append(const Mesh& other, const Pose& T_this_other = Pose::Identity());
  Eigen::AlignedBox3f bounds() const;
};

}  // namespace scslam::sim
