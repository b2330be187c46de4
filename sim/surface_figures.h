// Figures of the points as they lie in space: ground, spacing, shape of neighbourhoods, what Scan Context sees.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "sim/realism_figures.h"

namespace scslam::sim {

using Points = std::vector<Eigen::Vector3d>;  ///< frame: sensor, z up [m]

void measureGround(const Points& points, RealismFigures& figures);
/// @param columns firings a sweep: the azimuth step is 2 pi / columns.
void measureSpacing(const Points& points, int columns, RealismFigures& figures);
/// Centroids of 0.2 m voxels within 40 m, every second one judged by the points of its 1 m neighbourhood.
void measureShape(const Points& points, RealismFigures& figures);
void measureScanContext(const Points& points, RealismFigures& figures);

}  // namespace scslam::sim
