// House fronts: walls with recessed windows, balconies, doors, pipes and awnings, as streets have them.
#pragma once
#include "sim/mesh_builder.h"

namespace scslam::sim {

/// Where a front stands: its left lower corner seen from outside, and the direction to the right.
struct FrontPlace {
  Eigen::Vector3d corner;  ///< [m]
  Eigen::Vector3d right;   ///< unit, horizontal
  double width, height;    ///< [m]
  Eigen::Vector3d outward() const { return right.cross(Eigen::Vector3d::UnitZ()); }
};

struct FrontStyle {
  std::string wall = "plaster";
  double storey_m = 3, bay_m = 3;
  double recess_m = 0.22;
  double balcony_share = 0.25;  ///< of the bays above the ground floor
  double clutter = 1;           ///< pipes, awnings, boxes, steps: 0 none … 1 many
};

void addFront(MeshBuilder& builder, const FrontPlace& place, const FrontStyle& style, RandomSequence& random);

/// A house: a front to the street, plain walls elsewhere, a flat or pitched roof. @param depth behind the front [m].
void addHouse(MeshBuilder& builder, const FrontPlace& place, double depth, const FrontStyle& style,
              RandomSequence& random);

}  // namespace scslam::sim
