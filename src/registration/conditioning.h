// Which directions of motion does an overlap fix? A corridor fixes five of six, open ground three.
//
// A direction counts as fixed when moving along it changes the residuals by more than the noise of the normals would
// make believe. Translations and rotations are compared as lengths: a rotation by how far it moves the points on
// average, about its own axis (a long corridor is known well in roll, although its points are far away). After Zhang,
// Kaess, Singh, "On degeneracy of optimization-based state estimation" (ICRA 2016), with the scaling added.
#pragma once
#include "scslam/core/cloud.h"

namespace scslam {

struct Conditioning {
  int unfixed_axes = 0;
  Matrix6d unfixed = Matrix6d::Zero();      ///< takes the part of a tangent vector in the unfixed directions
  Matrix6d information = Matrix6d::Zero();  ///< H without them; they are its null space
};

/// @param H sum of w J^T J (tangent of core/pose.h, frame source). @param source the points it is made of.
/// @param least_share of the information of the translations below which a direction is unfixed.
/// @param planar x, y and yaw only; the other axes are neither fixed nor unfixed.
Conditioning conditioningOf(const Matrix6d& H, const Cloud& source, double least_share, bool planar);

}  // namespace scslam
