#include "scslam/core/deskew.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace scslam {
namespace {

// Exact poses at the ends of kSteps equal slices of the sweep; between them the chord of the matrix entries, whose
// error at 5 rad/s and 0.1 s is (w dt / kSteps)^2 / 8 = 8e-6 of the range.
constexpr int kSteps = 64;

using Row34 = Eigen::Matrix<float, 3, 4, Eigen::RowMajor>;

std::vector<Row34> posesOfSweep(float begin, float slice, const Vector6d& twist) {
  std::vector<Row34> poses(kSteps + 2);
  for (int k = 0; k < kSteps + 2; ++k) {
    const double t = static_cast<double>(begin) + static_cast<double>(slice) * k;
    Eigen::Matrix<double, 3, 4> T;
    T << so3Exp(t * twist.tail<3>()), t * twist.head<3>();
    poses[static_cast<std::size_t>(k)] = T.cast<float>();
  }
  return poses;
}

}  // namespace

double sweepDuration(const Cloud& cloud) {
  float longest = 0;
  for (const float dt : cloud.dt) longest = std::max(longest, std::isfinite(dt) ? std::abs(dt) : 0.0f);
  return static_cast<double>(longest);
}

double meanTime(const Cloud& cloud) {
  double sum = 0;
  for (const float dt : cloud.dt) sum += std::isfinite(dt) ? static_cast<double>(dt) : 0.0;
  return cloud.hasTime() ? sum / static_cast<double>(cloud.size()) : 0.0;
}

void deskew(Cloud& cloud, const Vector6d& twist) {
  if (!cloud.hasTime() || twist.isZero()) return;
  float begin = 0, end = 0;
  for (const float dt : cloud.dt) {
    if (!std::isfinite(dt)) continue;
    begin = std::min(begin, dt);
    end = std::max(end, dt);
  }
  if (begin == end) return;
  const float slice = (end - begin) / kSteps;
  const std::vector<Row34> poses = posesOfSweep(begin, slice, twist);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float dt = std::isfinite(cloud.dt[i]) ? cloud.dt[i] : 0.0f;
    const float position = (dt - begin) / slice;
    const auto k = static_cast<std::size_t>(position);
    const float u = position - static_cast<float>(k);
    const Row34 T = (1.0f - u) * poses[k] + u * poses[k + 1];
    const Eigen::Vector3f p = T.leftCols<3>() * cloud.point(i) + T.col(3);
    cloud.x[i] = p.x(), cloud.y[i] = p.y(), cloud.z[i] = p.z();
  }
}

}  // namespace scslam
