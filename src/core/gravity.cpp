#include "scslam/core/gravity.h"

#include <array>
#include <cmath>

namespace scslam {

Eigen::Matrix3d levelling(const Pose& T_odom_base) {
  return Eigen::AngleAxisd(-yawOf(T_odom_base), Eigen::Vector3d::UnitZ()) * T_odom_base.linear();
}

double groundHeight(const Cloud& cloud_level, double radius_m) {
  constexpr double kCell = 0.05, kLowest = -20;
  std::array<std::size_t, 800> histogram{};  // -20 m .. 20 m
  std::size_t total = 0;
  const auto radius2 = static_cast<float>(radius_m * radius_m);
  for (std::size_t i = 0; i < cloud_level.size(); ++i) {
    if (cloud_level.x[i] * cloud_level.x[i] + cloud_level.y[i] * cloud_level.y[i] > radius2) continue;
    const double cell = std::floor((cloud_level.z[i] - kLowest) / kCell);
    if (!(cell >= 0 && cell < static_cast<double>(histogram.size()))) continue;
    ++histogram[static_cast<std::size_t>(cell)];
    ++total;
  }
  std::size_t below = 0;
  for (std::size_t cell = 0; cell < histogram.size(); ++cell) {
    below += histogram[cell];
    if (total > 0 && below * 20 >= total) return kLowest + (static_cast<double>(cell) + 0.5) * kCell;
  }
  return 0;
}

}  // namespace scslam
