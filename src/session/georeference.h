// Where on Earth is the map? From the session's satellite fixes and its corrected poses.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "scslam/core/geodesy.h"
#include "scslam/session/records.h"

namespace scslam {

/// East-north-up at `origin`, placed in the map. The map is level, so both differ by a heading and a shift.
struct Georeference {
  Geodetic origin;  ///< of the ENU frame: the first fix
  Pose T_map_enu = Pose::Identity();
  double rms_m = 0;       ///< horizontal, of the fixes that were used
  std::size_t fixes = 0;  ///< used; the others lie far off
  Geodetic toGeodetic(const Eigen::Vector3d& p_map) const;
};

struct GeoreferenceLimits {
  std::size_t min_fixes = 10;
  double min_spread_m = 10;  ///< of the positions, root mean square about their mean: a shorter way gives no heading
};

/// Least squares over heading and shift, repeated without the fixes that lie further off than three times the median.
/// @return nullopt when there are too few fixes or they lie too close together.
std::optional<Georeference> georeference(const std::vector<GnssRecord>& gnss, const std::vector<Pose>& T_map_base,
                                         const GeoreferenceLimits& limits = {});

/// georeference.yaml: origin, transform, UTM zone of the origin.
std::string formatGeoreference(const Georeference& georeference);

}  // namespace scslam
