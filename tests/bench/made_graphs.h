// Pose graphs of two kinds that back-ends are compared on, made from truth: deterministic, honest information matrices.
#pragma once
#include <string>
#include <vector>

#include "scslam/core/counter_random.h"
#include "scslam/graph/pose_graph.h"

namespace scslam::bench {

struct MadeGraph {
  std::string name;
  PoseGraph graph;          ///< poses: the odometry, integrated
  std::vector<Pose> truth;  ///< empty for a graph that comes from a file
};

/// Standard deviations of a measurement, m and rad on each axis.
struct Noise {
  double translation, rotation;
};

class GraphMaker {
 public:
  GraphMaker(const std::string& name, std::vector<Pose> truth, std::uint64_t seed)
      : made_{name, {}, std::move(truth)}, random_(CounterRandom(seed, RandomStream::kDrive)) {}

  void add(FactorKind kind, std::uint32_t i, std::uint32_t j, const Noise& noise) {
    Factor factor{kind, i, j, made_.truth[i].inverse() * made_.truth[j]};
    Vector6d error, information;
    for (int axis = 0; axis < 6; ++axis) {
      const double sigma = axis < 3 ? noise.translation : noise.rotation;
      error(axis) = sigma * random_.normal();
      information(axis) = 1 / (sigma * sigma);
    }
    factor.T_i_j = retract(factor.T_i_j, error);
    factor.information = information.asDiagonal();
    made_.graph.factors.push_back(factor);
    if (kind == FactorKind::kOdometry) made_.graph.poses.push_back(made_.graph.poses.back() * factor.T_i_j);
  }

  void addOdometry(const Noise& noise) {
    made_.graph.poses = {made_.truth.front()};
    for (std::uint32_t k = 1; k < made_.truth.size(); ++k) add(FactorKind::kOdometry, k - 1, k, noise);
  }

  MadeGraph take() { return std::move(made_); }
  const std::vector<Pose>& truth() const { return made_.truth; }

 private:
  MadeGraph made_;
  RandomSequence random_;
};

/// A car in a town of square blocks: straight on or around a corner at each crossing, drawn at random.
inline std::vector<Pose> driveThroughTown(std::size_t poses, std::uint64_t seed) {
  constexpr int kBlock = 120, kCorner = 10, kTown = 5;  // steps a side, steps of a corner, blocks a side
  constexpr double kStep_m = 0.8;
  RandomSequence random(CounterRandom(seed, RandomStream::kWorld));
  std::vector<Pose> truth = {Pose::Identity()};
  int x = 0, y = 0, heading = 0;  // the crossing ahead, quarter turns
  const auto inTown = [&](int quarter) {
    const int ahead_x = x + (quarter == 0) - (quarter == 2), ahead_y = y + (quarter == 1) - (quarter == 3);
    return ahead_x >= 0 && ahead_x < kTown && ahead_y >= 0 && ahead_y < kTown;
  };
  const auto go = [&](int steps, double turn) {
    for (int k = 0; k < steps && truth.size() < poses; ++k)
      truth.push_back(truth.back() * poseFromYaw(turn / steps, {kStep_m, 0, 0}));
  };
  while (truth.size() < poses) {
    int turn = 0;
    do turn = random.below(3) - 1;
    while (!inTown((heading + turn + 4) % 4));
    go(kCorner, turn * M_PI / 2);
    heading = (heading + turn + 4) % 4;
    x += (heading == 0) - (heading == 2), y += (heading == 1) - (heading == 3);
    go(kBlock, 0);
  }
  return truth;
}

/// As long as KITTI 00 and with as many loops: chains of odometry, here and there a revisit.
inline MadeGraph roadGraph() {
  constexpr std::size_t kPoses = 4541, kLoops = 136, kApart = 300;
  constexpr double kRevisit_m = 3;
  GraphMaker maker("road (made)", driveThroughTown(kPoses, 3), 1);
  maker.addOdometry({0.02, 0.001});
  std::vector<std::pair<std::uint32_t, std::uint32_t>> revisits;
  for (std::uint32_t j = kApart; j < kPoses; ++j)
    for (std::uint32_t i = 0; i + kApart <= j; ++i)
      if ((maker.truth()[i].translation() - maker.truth()[j].translation()).norm() < kRevisit_m) {
        revisits.emplace_back(i, j);
        break;
      }
  for (std::size_t k = 0; k < kLoops; ++k) {
    const auto [i, j] = revisits[k * revisits.size() / kLoops];
    maker.add(FactorKind::kLoop, i, j, {0.05, 0.005});
  }
  return maker.take();
}

/// A walk around and around a torus, every pose joined to the one a ring before, with so much noise that descent from
/// the odometry ends far from the optimum.
inline MadeGraph torusGraph() {
  constexpr std::uint32_t kRings = 50, kRing = 100;
  constexpr std::size_t kLoops = 4049;
  std::vector<Pose> truth;
  for (std::uint32_t k = 0; k < kRings * kRing; ++k) {
    const double tube = 2 * M_PI * k / kRing, around = 2 * M_PI * k / (kRings * kRing);
    const Pose T_ring = poseFromYaw(around, Eigen::Vector3d::Zero()) * poseFromYaw(0, {4, 0, 0});
    Pose T_tube = Pose::Identity();
    T_tube.linear() = so3Exp({0, tube, 0});
    truth.push_back(T_ring * T_tube * poseFromYaw(0, {2, 0, 0}));
  }
  GraphMaker maker("torus (made)", std::move(truth), 2);
  maker.addOdometry({0.1, 0.05});
  const std::size_t pairs = (kRings - 1) * kRing;
  for (std::size_t k = 0; k < kLoops; ++k) {
    const auto i = static_cast<std::uint32_t>(k * pairs / kLoops);
    maker.add(FactorKind::kLoop, i, i + kRing, {0.1, 0.05});
  }
  return maker.take();
}

}  // namespace scslam::bench
