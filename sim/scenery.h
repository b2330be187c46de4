// What the generators of worlds share: uneven ground, lines and ribbons along them, a plain house.
#pragma once
#include <functional>

#include "sim/mesh_builder.h"

namespace scslam::sim {

/// Small unevenness of ground: two octaves of value noise, lattices of 2 m and 0.8 m. Real streets deviate from the
/// plane of a 2 m cell by 1 … 3.5 cm (std).
class RoughGround {
 public:
  /// @param std_m of the height. @param period_m repeats in x and y after this (a multiple of 4 m); 0: never.
  RoughGround(std::uint64_t seed, double std_m, double period_m = 0);
  double operator()(double x, double y) const;  ///< height [m], mean 0

 private:
  double octave(double x, double y, double cell_m, std::uint32_t index) const;
  CounterRandom random_;
  double std_m_, period_m_;
};

/// A polyline in the world [m].
using Line = std::vector<Eigen::Vector3d>;

double lengthOf(const Line& line);
/// Points every `step_m` or a little less, corners not kept. Closed: the way back to the first point is part of it and
/// the first point is repeated at the end.
Line resampled(const Line& line, double step_m, bool closed = false);
/// Points on a circle in the plane z = centre.z, counter-clockwise for to > from [deg], both ends included.
Line arc(const Eigen::Vector3d& centre, double radius, double from_deg, double to_deg, double step_deg = 5);
/// Unit vectors to the left of each point of a line, level. Closed: its last point is its first.
Line leftOf(const Line& line, bool closed = false);

/// A strip along a line: at each point from right to left the `offsets` [m] (left positive, ascending), each at
/// height z(point of the surface in plan, offset, index along the line).
void addRibbon(MeshBuilder& builder, const Line& line, const std::vector<double>& offsets,
               const std::function<double(const Eigen::Vector3d&, double, std::size_t)>& z, bool closed = false);
/// The same, at height z(x, y) + lift where `lifts` has one value per offset.
void addRibbon(MeshBuilder& builder, const Line& line, const std::vector<double>& offsets,
               const std::vector<double>& lifts, const std::function<double(double, double)>& z, bool closed = false);
/// n + 1 numbers from a to b.
std::vector<double> steps(double a, double b, int n);

/// A house with windows, door, gable roof and chimney. Pose: middle of its floor, x along the ridge, door at -y.
void addHouse(MeshBuilder& builder, const Pose& T_world_house, double length, double width, int storeys,
              RandomSequence& random);
/// Windows and doors of one wall: openings 12 cm deep in a wall from a to b (seen from outside on the left hand a, on
/// the right hand b), `height` [m], one row of windows per storey of 3 m and a door in the middle if wanted. The wall
/// itself is included. @param wall its material.
void addFacade(MeshBuilder& builder, const Eigen::Vector3d& a, const Eigen::Vector3d& b, double height,
               const std::string& wall, bool door);

}  // namespace scslam::sim
