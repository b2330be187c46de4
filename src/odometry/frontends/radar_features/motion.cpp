#include "scslam/odometry/frontends/radar_features/motion.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "scslam/core/counter_random.h"

namespace scslam::radar_features {
namespace {

/// Where a point is that is shown at p by a radar that moves with the base.
Eigen::Vector2d withoutDoppler(const Eigen::Vector2d& p, const Eigen::Vector3d& twist, const MotionModel& model) {
  if (model.doppler_beta == 0) return p;
  const Eigen::Vector2d ray = p - model.sensor;
  const double range2 = ray.squaredNorm();
  if (!(range2 > 0)) return p;
  const Eigen::Vector2d velocity = twist.head<2>() + twist.z() * Eigen::Vector2d(-model.sensor.y(), model.sensor.x());
  return p + model.doppler_beta * velocity.dot(ray) / range2 * ray;
}

/// Takes the velocity at the beginning of an arc of this angle to the mean one along it.
Eigen::Matrix2d arcOf(double angle) {
  const bool straight = std::abs(angle) < 1e-6;
  const double s = straight ? 1 - angle * angle / 6 : std::sin(angle) / angle,
               c = straight ? 0.5 * angle : (1 - std::cos(angle)) / angle;
  return (Eigen::Matrix2d() << s, -c, c, s).finished();
}

/// Gauss-Newton on the chosen pairs; with `width_m` > 0 weighed by Geman-McClure's kernel of that width.
Eigen::Vector3d refined(const std::vector<Pair>& pairs, const std::vector<std::uint32_t>& chosen, Eigen::Vector3d twist,
                        const MotionModel& model, double width_m, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    Eigen::Matrix3d H = 1e-9 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (const std::uint32_t i : chosen) {
      const Pair& pair = pairs[i];
      const Eigen::Vector2d e = residualOf(pair, twist, model), placed = e + withoutDoppler(pair.b, twist, model);
      const double s = width_m > 0 ? width_m * width_m / (width_m * width_m + e.squaredNorm()) : 1.0;
      // moved(twist + d, time) = moved(d, time) * moved(twist, time) to first order; the Doppler shift hardly changes.
      Eigen::Matrix<double, 2, 3> J;
      J << pair.time, 0, -pair.time * placed.y(), 0, pair.time, pair.time * placed.x();
      H += s * s * J.transpose() * J;
      g += s * s * J.transpose() * e;
    }
    const Eigen::Vector3d step = H.ldlt().solve(g);
    if (!step.allFinite()) return twist;
    twist -= step;
    if (step.head<2>().norm() < 1e-4 && std::abs(step.z()) < 1e-6) break;
  }
  return twist;
}

std::vector<std::uint32_t> inliersOf(const std::vector<Pair>& pairs, const Eigen::Vector3d& twist,
                                     const MotionModel& model, double inlier_m) {
  std::vector<std::uint32_t> inliers;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (residualOf(pairs[i], twist, model).squaredNorm() < inlier_m * inlier_m)
      inliers.push_back(static_cast<std::uint32_t>(i));
  return inliers;
}

}  // namespace

std::vector<Pair> pruned(const std::vector<Pair>& pairs, double tolerance_m) {
  const std::size_t n = pairs.size();
  std::vector<std::uint8_t> agrees(n * n, 0);
  std::vector<int> friends(n, 0);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      const double apart_a = (pairs[i].a_still - pairs[j].a_still).norm(),
                   apart_b = (pairs[i].b_still - pairs[j].b_still).norm();
      if (!(std::abs(apart_a - apart_b) < tolerance_m)) continue;
      agrees[i * n + j] = agrees[j * n + i] = 1;
      ++friends[i], ++friends[j];
    }
  std::vector<std::uint8_t> kept(n, 1);
  for (std::size_t left = n; left > 0; --left) {
    std::size_t loneliest = n;
    for (std::size_t i = 0; i < n; ++i)
      if (kept[i] != 0 && (loneliest == n || friends[i] < friends[loneliest])) loneliest = i;
    if (2 * static_cast<std::size_t>(friends[loneliest]) + 1 >= left) break;
    kept[loneliest] = 0;
    for (std::size_t j = 0; j < n; ++j) friends[j] -= agrees[loneliest * n + j];
  }
  std::vector<Pair> result;
  for (std::size_t i = 0; i < n; ++i)
    if (kept[i] != 0) result.push_back(pairs[i]);
  return result;
}

Eigen::Isometry2d moved(const Eigen::Vector3d& twist, double time) {
  Eigen::Isometry2d T = Eigen::Isometry2d::Identity();
  T.linear() = Eigen::Rotation2Dd(twist.z() * time).toRotationMatrix();
  T.translation() = time * arcOf(twist.z() * time) * twist.head<2>();
  return T;
}

Eigen::Vector3d twistOfMotion(const Eigen::Isometry2d& T, double time) {
  const double angle = std::atan2(T.linear()(1, 0), T.linear()(0, 0));
  Eigen::Vector3d twist;
  twist << arcOf(angle).inverse() * T.translation() / time, angle / time;
  return twist;
}

Eigen::Vector2d residualOf(const Pair& pair, const Eigen::Vector3d& twist, const MotionModel& model) {
  return moved(twist, pair.time) * withoutDoppler(pair.a, twist, model) - withoutDoppler(pair.b, twist, model);
}

Motion motionOf(const std::vector<Pair>& pairs, const Eigen::Vector3d& twist, const MotionModel& model,
                const MotionOptions& options) {
  constexpr double kEnough = 0.9;  // share of inliers at which no better hypothesis is looked for
  Motion best;
  best.twist = twist;
  if (pairs.size() < 3) return best;
  RandomSequence random(CounterRandom(options.seed, RandomStream::kRadar), 3);
  const int n = static_cast<int>(pairs.size());
  for (int k = 0; k < options.iterations; ++k) {
    const auto i = static_cast<std::uint32_t>(random.below(n)), j = static_cast<std::uint32_t>(random.below(n));
    if (i == j || (pairs[i].a - pairs[j].a).norm() < 4 * options.inlier_m) continue;  // no lever, no heading
    const Eigen::Vector3d candidate = refined(pairs, {i, j}, twist, model, 0, 4);
    auto inliers = inliersOf(pairs, candidate, model, options.inlier_m);
    if (inliers.size() <= best.inliers.size()) continue;
    best.twist = candidate, best.inliers = std::move(inliers);
    if (static_cast<double>(best.inliers.size()) > kEnough * n) break;
  }
  if (best.inliers.size() < 3) return best;
  for (int round = 0; round < 5; ++round) {
    best.twist = refined(pairs, best.inliers, best.twist, model, options.inlier_m, 10);
    auto inliers = inliersOf(pairs, best.twist, model, options.inlier_m);
    if (inliers.size() < 3) return best;
    const bool settled = inliers == best.inliers;
    best.inliers = std::move(inliers);
    if (settled) break;
  }
  for (const std::uint32_t i : best.inliers) best.residuals.push_back(residualOf(pairs[i], best.twist, model).norm());
  best.found = true;
  return best;
}

}  // namespace scslam::radar_features
