#include "scslam/odometry/usable_points.h"

#include <algorithm>
#include <cmath>

namespace scslam {

Cloud usablePoints(const Scan& scan, double min_range_m, double max_range_m) {
  const double least = min_range_m > 0 ? min_range_m : scan.planar ? 0.1 : 1.0;
  const auto min2 = static_cast<float>(least * least);
  const auto max2 = static_cast<float>(max_range_m * max_range_m);
  const Cloud& all = scan.cloud;
  std::vector<std::uint8_t> keep(all.size());
  std::size_t kept = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const float range2 = all.x[i] * all.x[i] + all.y[i] * all.y[i] + all.z[i] * all.z[i];
    keep[i] = range2 >= min2 && range2 <= max2;  // false for NaN
    kept += keep[i];
  }
  Cloud cloud = all;
  if (kept < all.size()) cloud.filter(keep);
  if (!scan.T_base_sensor.matrix().isIdentity(0.0)) transformInPlace(cloud, scan.T_base_sensor);
  return cloud;
}

double voxelFor(const Cloud& cloud, bool planar) {
  std::vector<float> range2(cloud.size());
  for (std::size_t i = 0; i < range2.size(); ++i) range2[i] = cloud.point(i).squaredNorm();
  const auto middle = range2.begin() + static_cast<std::ptrdiff_t>(range2.size() / 2);
  std::nth_element(range2.begin(), middle, range2.end());
  const double wanted = 0.05 * std::sqrt(static_cast<double>(*middle));
  return planar ? std::clamp(wanted, 0.15, 2.0) : std::clamp(wanted, 0.25, 0.5);
}

}  // namespace scslam
