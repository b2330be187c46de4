// Edge and plane features along each ring of a scan (Zhang & Singh, "LOAM: LiDAR odometry and mapping in real time",
// RSS 2014, Sec. V-A), with thresholds that are lengths.
//
//   o_i = | sum_{|j-i| <= 5, j != i} (p_j - p_i) | / 10     how far a point stands out from its neighbours [m]
//
// A point is no edge where a nearer surface hides what it borders on, and where the beam only grazes its surface.
#pragma once
#include <cstdint>
#include <vector>

#include "scslam/core/parallel.h"
#include "scslam/core/params.h"
#include "scslam/odometry/scan_rings.h"

namespace scslam {

struct CurvatureParams : ParamSetOf<CurvatureParams> {
  int sectors = 6;       ///< of a ring, so that features come from all around
  int sharp = 2;         ///< edges a sector that are matched scan to scan
  int less_sharp = 20;   ///< edges a sector that are matched with the map and make it
  int flat = 4;          ///< flat points a sector that are matched scan to scan
  double edge_m = 0.03;  ///< an edge stands out by more than this, and by edge_share of its neighbourhood
  double edge_share = 0.15;
  double flat_m = 0.03;  ///< a flat point stands out by less than this
  double hidden_m = 0.3;
  double grazing_share = 0.02;
  void describe(ParamVisitor& visitor) override;
};

/// Numbers of points.
struct CurvatureFeatures {
  std::vector<std::uint32_t> sharp, less_sharp;  ///< less_sharp includes sharp
  std::vector<std::uint32_t> flat, less_flat;    ///< less_flat: all points that are no edge
};

/// What a point may become, as bits.
enum FeatureRole : std::uint8_t { kMayBeEdge = 1, kMayBeFlat = 2, kMayBeSurface = 4, kMayBeAll = 7 };

/// @param origin of the beams, in the frame of the cloud.
/// @param roles one entry a point; empty: every point may be anything.
CurvatureFeatures curvatureFeatures(const Cloud& cloud, const ScanRings& rings, const Eigen::Vector3f& origin,
                                    const CurvatureParams& params, ThreadPool& threads,
                                    const std::vector<std::uint8_t>& roles = {});

}  // namespace scslam
