// Small pose graphs with known answers, deterministic.
#pragma once
#include <random>

#include "scslam/graph/pose_graph.h"

namespace scslam::test {

inline Vector6d randomVector(std::mt19937& random, double trans, double rot) {
  // Not std::uniform_real_distribution: its numbers differ between standard libraries.
  const auto unit = [&] { return 2.0 * random() / 4294967295.0 - 1; };
  Vector6d v;
  for (int k = 0; k < 6; ++k) v(k) = unit() * (k < 3 ? trans : rot);
  return v;
}

inline Pose randomPose(std::mt19937& random) { return retract(Pose::Identity(), randomVector(random, 5, 1.5)); }

/// Full, well-conditioned, not diagonal.
inline Matrix6d randomInformation(std::mt19937& random) {
  Matrix6d A;
  for (int c = 0; c < 6; ++c) A.col(c) = randomVector(random, 1, 1);
  return A * A.transpose() + 0.5 * Matrix6d::Identity();
}

inline Factor between(const std::vector<Pose>& truth, std::uint32_t i, std::uint32_t j, FactorKind kind,
                      const Vector6d& noise = Vector6d::Zero()) {
  Factor factor;
  factor.kind = kind;
  factor.i = i;
  factor.j = j;
  factor.T_i_j = retract(truth[i].inverse() * truth[j], noise);
  return factor;
}

/// A square of `side` nodes a side walked `laps` times, odometry with noise of a tenth of the loops' information; loops
/// join equal places of consecutive laps. graph.poses is the integrated odometry.
struct SquareWalk {
  std::vector<Pose> truth;
  PoseGraph graph;

  SquareWalk(int side, int laps, double noise, std::uint32_t seed = 1, bool planar = false) {
    std::mt19937 random(seed);
    Pose T = Pose::Identity();
    for (int k = 0; k < 4 * side * laps; ++k) {
      truth.push_back(T);
      T = T * poseFromYaw((k + 1) % side == 0 ? M_PI / 2 : 0, {1, 0, 0});
    }
    graph.planar = planar;
    const auto drift = [&] {
      Vector6d v = randomVector(random, noise, noise / 5);
      if (planar) v.segment<3>(2).setZero();
      return v;
    };
    for (std::uint32_t k = 1; k < truth.size(); ++k) {
      graph.factors.push_back(between(truth, k - 1, k, FactorKind::kOdometry, drift()));
      graph.factors.back().information *= 1 / std::max(1e-4, noise * noise);
    }
    for (std::uint32_t k = static_cast<std::uint32_t>(4 * side); k < truth.size(); k += 3) {
      graph.factors.push_back(between(truth, k - static_cast<std::uint32_t>(4 * side), k, FactorKind::kLoop, drift()));
      graph.factors.back().information *= 1 / std::max(1e-4, noise * noise);
    }
    graph.poses.push_back(truth[0]);
    for (std::uint32_t k = 1; k < truth.size(); ++k)
      graph.poses.push_back(graph.poses[k - 1] * graph.factors[k - 1].T_i_j);
  }

  double worstError() const {
    double worst = 0;
    for (std::size_t k = 0; k < truth.size(); ++k)
      worst = std::max(worst, (graph.poses[k].translation() - truth[k].translation()).norm());
    return worst;
  }
};

}  // namespace scslam::test
