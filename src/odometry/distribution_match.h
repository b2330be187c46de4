// Voxelised generalised ICP: distributions of a scan against the distributions of a map (Segal, "Generalized-ICP", RSS
// 2009; Koide, "Voxelized GICP for fast and accurate 3D point cloud registration", ICRA 2021).
//
//   minimise  sum_i rho( d_i^T (C_i^map + R C_i^scan R^T)^-1 d_i )
//
// Both covariances are those of a plane: the variance found along the normal, and a wide one within the plane, where a
// sample of points says nothing of where the surface is. The planes of the scan come from its own voxels, as those of
// the map do: no search for twenty neighbours of each point.
#pragma once
#include <vector>

#include "scslam/odometry/block_match.h"

namespace scslam {

/// Points of a scan with the plane around each.
struct PlanarPoints {
  Cloud cloud;
  std::vector<float> nx, ny, nz;  ///< unit normals, frame scan
  std::vector<float> variance;    ///< along the normal [m^2]; negative where no plane was found
};

/// One point a voxel of voxel_m, with planes from voxels of plane_m, 2 plane_m and 4 plane_m (the finest that holds
/// one).
PlanarPoints planarPoints(const Cloud& cloud, double voxel_m, double plane_m, const SurfelRules& rules);

/// @param spread_m standard deviation within a plane.
MatchSystem lineariseDistributions(const SurfacePyramid& map, LevelRange levels, const PlanarPoints& source,
                                   double spread_m, const Pose& T_map_scan, const MatchKernel& kernel,
                                   ThreadPool& threads);

}  // namespace scslam
