#include "scslam/session/georeference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace scslam {
namespace {

using Eigen::Vector3d;

struct Pair {
  Vector3d map, enu;
  double weight;  ///< 1 / horizontal variance
};

/// Weighted heading and shift with map = R_z(yaw) enu + t.
Pose aligned(const std::vector<Pair>& pairs) {
  Vector3d mean_map = Vector3d::Zero(), mean_enu = Vector3d::Zero();
  double sum = 0;
  for (const Pair& p : pairs) mean_map += p.weight * p.map, mean_enu += p.weight * p.enu, sum += p.weight;
  mean_map /= sum, mean_enu /= sum;
  double along = 0, across = 0;
  for (const Pair& p : pairs) {
    const Vector3d m = p.map - mean_map, e = p.enu - mean_enu;
    along += p.weight * (e.x() * m.x() + e.y() * m.y());
    across += p.weight * (e.x() * m.y() - e.y() * m.x());
  }
  Pose T = poseFromYaw(std::atan2(across, along), Vector3d::Zero());
  T.translation() = mean_map - T.linear() * mean_enu;
  return T;
}

double spread(const std::vector<Pair>& pairs) {
  Vector3d mean = Vector3d::Zero();
  for (const Pair& p : pairs) mean += p.enu / static_cast<double>(pairs.size());
  double sum = 0;
  for (const Pair& p : pairs) sum += (p.enu - mean).head<2>().squaredNorm();
  return std::sqrt(sum / static_cast<double>(pairs.size()));
}

double offBy(const Pose& T_map_enu, const Pair& p) { return (T_map_enu * p.enu - p.map).head<2>().norm(); }

}  // namespace

Geodetic Georeference::toGeodetic(const Vector3d& p_map) const {
  return LocalEnu(origin).toGeodetic(T_map_enu.inverse() * p_map);
}

std::optional<Georeference> georeference(const std::vector<GnssRecord>& gnss, const std::vector<Pose>& T_map_base,
                                         const GeoreferenceLimits& limits) {
  if (gnss.size() < std::max<std::size_t>(limits.min_fixes, 2)) return std::nullopt;
  Georeference result;
  const GnssFix& first = gnss.front().fix;
  result.origin = {first.latitude_deg, first.longitude_deg, first.height_m};
  const LocalEnu enu(result.origin);
  std::vector<Pair> pairs;
  for (const GnssRecord& record : gnss) {
    if (record.keyframe >= T_map_base.size()) continue;
    const GnssFix& fix = record.fix;
    const double variance = 0.5 * (fix.covariance_m2(0, 0) + fix.covariance_m2(1, 1));
    pairs.push_back({T_map_base[record.keyframe] * record.antenna_in_keyframe_m,
                     enu.fromGeodetic({fix.latitude_deg, fix.longitude_deg, fix.height_m}),
                     1 / std::max(variance, 1e-4)});
  }
  std::vector<Pair> used = pairs;
  for (int round = 0; round < 4; ++round) {
    if (used.size() < limits.min_fixes || spread(used) < limits.min_spread_m) return std::nullopt;
    result.T_map_enu = aligned(used);
    std::vector<double> off;
    for (const Pair& p : pairs) off.push_back(offBy(result.T_map_enu, p));
    std::nth_element(off.begin(), off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2), off.end());
    const double limit = std::max(3 * off[off.size() / 2], 0.05);
    used.clear();
    for (const Pair& p : pairs)
      if (offBy(result.T_map_enu, p) <= limit) used.push_back(p);
  }
  double sum = 0;
  for (const Pair& p : used) sum += std::pow(offBy(result.T_map_enu, p), 2);
  result.fixes = used.size();
  result.rms_m = used.empty() ? 0 : std::sqrt(sum / static_cast<double>(used.size()));
  return result;
}

std::string formatGeoreference(const Georeference& g) {
  const Utm utm = toUtm(g.origin);
  const Pose T_enu_map = g.T_map_enu.inverse();
  const Vector3d& t = T_enu_map.translation();
  return fmt::format(
      "# p_enu = R_z(yaw) p_map + t: east, north, up [m] at the origin (WGS 84, height above the ellipsoid)\n"
      "origin: {{latitude_deg: {:.10f}, longitude_deg: {:.10f}, height_m: {:.4f}}}\n"
      "T_enu_map: {{yaw_deg: {:.9f}, translation_m: [{:.6f}, {:.6f}, {:.6f}]}}\n"
      "fixes: {}\nrms_horizontal_m: {:.4f}\n"
      "utm_of_origin: {{epsg: {}, easting_m: {:.4f}, northing_m: {:.4f}, grid_convergence_deg: {:.9f}, scale: "
      "{:.9f}}}\n",
      g.origin.latitude_deg, g.origin.longitude_deg, g.origin.height_m, yawOf(T_enu_map) * 180 / M_PI, t.x(), t.y(),
      t.z(), g.fixes, g.rms_m, utm.epsg(), utm.easting_m, utm.northing_m, utm.convergence_deg, utm.scale);
}

}  // namespace scslam
