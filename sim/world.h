// A world: what stands still, and what moves along paths.
#pragma once
#include <string>
#include <vector>

#include "sim/material.h"
#include "sim/mesh.h"

namespace scslam::sim {

/// Something that moves: a mesh in its own frame (x forward, on z = 0) along a polyline.
struct Actor {
  Mesh mesh;
  Label label = Label::kCar;
  std::uint16_t instance = 0;
  std::vector<Eigen::Vector3d> path;  ///< [m], world; at least two points, or one for something that only stands
  double speed_mps = 8;
  double start_m = 0;  ///< where on the path it is at time 0
  bool loops = true;   ///< at the end it goes on from the start; else it stays there
  /// T_world_actor at time t [s]: on the path, heading along it, corners rounded.
  Pose at(double t) const;
  double pathLength() const;
};

/// A way through the world that a robot can take: 1.5 m clear on both sides.
struct Route {
  std::string name;
  std::vector<Eigen::Vector3d> points;  ///< [m]; z near the ground
  bool closed = false;
};

struct World {
  std::string name;
  Mesh mesh;
  std::vector<Actor> actors;
  std::vector<Route> routes;
};

}  // namespace scslam::sim
