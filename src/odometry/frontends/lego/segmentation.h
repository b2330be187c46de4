// Ground and clusters of a scan on its range image (Shan & Englot, "LeGO-LOAM", IROS 2018, Sec. III-B; clusters by the
// angle criterion of Bogoslavskyi & Stachniss, IROS 2016).
#pragma once
#include <cstdint>
#include <vector>

#include "scslam/core/params.h"
#include "scslam/odometry/scan_rings.h"

namespace scslam::lego {

struct SegmentationParams : ParamSetOf<SegmentationParams> {
  int columns = 0;                     ///< of the range image, a full turn; 0: as dense as the fullest ring
  double ground_slope_deg = 10;        ///< between beams above each other, from level (frame base)
  double ground_elevation_deg = 0;     ///< ground is looked for in rings below this elevation (frame base)
  double cluster_angle_deg = 60;       ///< two returns belong together when the line through both is steeper
  int cluster_points = 30;             ///< a cluster has so many points …
  int thin_points = 5, thin_rows = 3;  ///< … or so many that span so many rings: poles and trunks
  void describe(ParamVisitor& visitor) override;
};

enum class Segment : std::uint8_t { kClutter, kGround, kCluster };

/// @param cloud_base frame base, z up. @return one entry a point. Points that share a cell with a nearer one are
/// clutter.
std::vector<Segment> segment(const Cloud& cloud_base, const ScanRings& rings, const Pose& T_base_sensor,
                             const SegmentationParams& params);

}  // namespace scslam::lego
