#include "scslam/apps/motion_scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace scslam {
namespace {

constexpr std::size_t kLeastStretches = 5;
constexpr double kTolerated = 0.03;
constexpr double kOutOfReach_s = 0.5;  // between a scan and the reference

double medianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void append(Trajectory& trajectory, Stamp stamp, const Pose& T) {
  if (trajectory.poses.empty() || stamp > trajectory.poses.back().stamp) trajectory.poses.push_back({stamp, T});
}

}  // namespace

std::optional<MotionScale> motionScale(const Trajectory& estimate, const Trajectory& reference, double stretch_m) {
  std::vector<double> ratios;
  std::optional<Eigen::Vector3d> from_estimate, from_reference;
  for (const auto& [stamp, T] : estimate.poses) {
    const auto other = reference.at(stamp, kOutOfReach_s);
    if (!other) {
      from_reference.reset();
      continue;
    }
    const Eigen::Vector3d here = T.translation(), there = other->translation();
    if (from_reference) {
      const double distance = (there - *from_reference).head<2>().norm();
      if (distance < stretch_m) continue;
      ratios.push_back((here - *from_estimate).head<2>().norm() / distance);
    }
    from_estimate = here, from_reference = there;
  }
  if (ratios.size() < kLeastStretches) return std::nullopt;
  MotionScale result;
  result.scale = medianOf(ratios), result.stretches = ratios.size();
  std::vector<double> off;
  for (const double ratio : ratios) off.push_back(std::abs(ratio - result.scale));
  // 1.4826 MAD is sigma, and a median of n has sqrt(pi / 2 n) of it.
  result.sigma = 1.4826 * medianOf(off) * std::sqrt(M_PI / 2 / static_cast<double>(ratios.size()));
  return result;
}

void MotionReference::add(const Scan& scan) {
  if (scan.T_odom_base) append(odometry_, scan.stamp, *scan.T_odom_base);
  for (const GnssFix& fix : scan.gnss) {
    const Geodetic place{fix.latitude_deg, fix.longitude_deg, fix.height_m};
    if (!enu_) enu_.emplace(place);
    Pose T = Pose::Identity();
    T.translation() = enu_->fromGeodetic(place);
    append(satellites_, fix.stamp, T);
  }
}

std::optional<Trajectory> MotionReference::trajectory(const std::optional<Trajectory>& truth,
                                                      std::string& source) const {
  source = truth ? "the truth" : !odometry_.poses.empty() ? "the recording's odometry" : "the satellite fixes";
  if (truth) return truth;
  if (!odometry_.poses.empty()) return odometry_;
  return satellites_.poses.empty() ? std::nullopt : std::optional(satellites_);
}

std::string scaleComplaint(const MotionScale& scale, double range_resolution_m, const std::string& reference) {
  const double off = std::abs(scale.scale - 1);
  if (off <= kTolerated || off <= 3 * scale.sigma || !(scale.scale > 0)) return "";
  return fmt::format(
      "the radar's motion is {:.3f} times that of {} (+- {:.3f}, {} stretches): its range resolution, taken as {} m, "
      "is "
      "probably {:.4f} m (--sensor FILE with radar: {{range_resolution_m: …}})",
      scale.scale, reference, scale.sigma, scale.stretches, range_resolution_m, range_resolution_m / scale.scale);
}

}  // namespace scslam
