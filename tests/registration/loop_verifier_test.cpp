#include "scslam/registration/loop_verifier.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "support/support.h"

namespace scslam {
namespace {

using test::IsNear;
using ::testing::HasSubstr;

struct Box {
  Eigen::Vector3d low, high;
};

/// Distance along the ray to the box's surface, seen from outside or inside; infinity: missed.
double hit(const Box& box, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  double near = -std::numeric_limits<double>::infinity(), far = -near;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (box.low[axis] - origin[axis]) / direction[axis],
                 b = (box.high[axis] - origin[axis]) / direction[axis];
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  if (far < std::max(near, 0.0)) return std::numeric_limits<double>::infinity();
  return near > 0 ? near : far;
}

/// A yard of 60 x 40 x 12 m, no two corners alike.
std::vector<Box> yard() {
  return {{{-30, -20, 0}, {30, 20, 12}}, {{-18, 6, 0}, {-9, 14, 7}},  {{4, -15, 0}, {13, -7, 9}},
          {{-24, -16, 0}, {-20, -3, 5}}, {{17, 5, 0}, {21.5, 16, 8}}, {{-4, 16, 0}, {1, 18.5, 4}}};
}

/// What a LiDAR of 48 x 720 beams at the base's origin sees of the world, without noise, frame base; one ring is level.
Cloud scanAt(const std::vector<Box>& world, const Pose& T_world_base, int rings = 48, int columns = 720) {
  Cloud cloud;
  for (int ring = 0; ring < rings; ++ring)
    for (int column = 0; column < columns; ++column) {
      const double elevation = rings == 1 ? 0 : (-25.0 + 40.0 * ring / rings + 0.013) * M_PI / 180;
      const double azimuth = (column + 0.37) * 2 * M_PI / columns;
      const Eigen::Vector3d d(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                              std::sin(elevation));
      double range = std::numeric_limits<double>::infinity();
      for (const Box& box : world)
        range = std::min(range, hit(box, T_world_base.translation(), T_world_base.linear() * d));
      if (range < 100)
        cloud.push(static_cast<float>(range * d.x()), static_cast<float>(range * d.y()),
                   static_cast<float>(range * d.z()));
    }
  return cloud;
}

/// Scans at these poses, the first being the target's frame.
LoopTarget targetOf(const std::vector<Box>& world, const std::vector<Pose>& T_world_base) {
  LoopTarget target;
  for (const Pose& T : T_world_base) {
    target.T_target_base.push_back(T_world_base.front().inverse() * T);
    target.clouds.push_back(std::make_shared<Cloud>(scanAt(world, T)));
    const Cloud placed = transformed(*target.clouds.back(), target.T_target_base.back());
    target.submap.x.insert(target.submap.x.end(), placed.x.begin(), placed.x.end());
    target.submap.y.insert(target.submap.y.end(), placed.y.begin(), placed.y.end());
    target.submap.z.insert(target.submap.z.end(), placed.z.begin(), placed.z.end());
  }
  return target;
}

LoopVerifier verifier(int threads = 1, const LoopGateParams& gates = {}) {
  return {Registry<Registration>::instance().create("voxel_planes", test::context(threads)), gates,
          Eigen::Vector3d::Zero()};
}

const Pose kPlace = poseFromYaw(0.4, {-2, -1, 1.7});

OdometryPrediction near(const Pose& T_match_query, double travelled_m = 300) {
  OdometryPrediction predicted;
  predicted.T_match_query = T_match_query * poseFromYaw(0.05, {1.1, -0.9, 0.2});
  predicted.travelled_m = travelled_m;
  return predicted;
}

TEST(LoopVerifier, ASyntheticLoopClosesUnderAMillimetreFromAnyStartForwardAndReverse) {
  const std::vector<Box> world = yard();
  LoopVerifier loops = verifier();
  loops.setTarget(
      targetOf(world, {kPlace, kPlace * poseFromYaw(0.1, {1, 0, 0}), kPlace * poseFromYaw(-0.1, {-1, 0, 0})}));
  std::mt19937 random(7);
  const auto within = [&random](double limit) { return limit * (static_cast<double>(random()) / 2147483648.0 - 1); };
  for (int k = 0; k < 12; ++k) {
    const double turned = k % 2 == 0 ? 0 : M_PI;  // forward, reverse
    const Pose T_match_query = poseFromYaw(turned + within(0.5), {within(4), within(3), within(0.1)});
    const Pose guess = poseFromYaw(yawOf(T_match_query) + within(0.12), Eigen::Vector3d::Zero());
    const Verification verdict =
        loops.verify(scanAt(world, kPlace * T_match_query), {guess}, near(T_match_query), false);
    EXPECT_EQ(verdict.refusal, "") << k;
    EXPECT_THAT(verdict.registration.T_target_source, IsNear(T_match_query, 0.001, 0.01)) << k;
  }
}

TEST(LoopVerifier, OneTargetServesManyScansAndGuesses) {
  const std::vector<Box> world = yard();
  const Pose here = poseFromYaw(0.2, {1, 0.5, 0}), there = poseFromYaw(3.0, {-2, 1, 0});
  LoopVerifier loops = verifier();
  loops.setTarget(targetOf(world, {kPlace}));
  loops.verify(scanAt(world, kPlace * there), {there}, near(there), false);
  const Verification again = loops.verify(scanAt(world, kPlace * here), {here}, near(here), false);
  LoopVerifier fresh = verifier(4);
  fresh.setTarget(targetOf(world, {kPlace}));
  const Verification first = fresh.verify(scanAt(world, kPlace * here), {here}, near(here), false);
  EXPECT_EQ(again.registration.T_target_source.matrix(), first.registration.T_target_source.matrix());
  EXPECT_EQ(again.registration.hessian, first.registration.hessian);
  EXPECT_EQ(again.free_space->target_overlap, first.free_space->target_overlap);
  EXPECT_EQ(again.refusal, "");
}

TEST(LoopVerifier, AsksForQualityWhereItIsOn) {
  const std::vector<Box> world = yard();
  const Pose here = poseFromYaw(0.2, {1, 0.5, 0});
  LoopGateParams gates;
  gates.quality.on = true;
  for (const double bias : {10.0, -10.0}) {
    gates.quality.bias = bias;
    LoopVerifier loops = verifier(1, gates);
    loops.setTarget(targetOf(world, {kPlace}));
    const std::string refusal = loops.verify(scanAt(world, kPlace * here), {here}, near(here), false).refusal;
    EXPECT_EQ(refusal.find("alignment quality") == 0, bias < 0) << refusal;
    EXPECT_EQ(refusal.empty(), bias > 0) << refusal;
  }
}

TEST(LoopVerifier, ClosesFromAGuessTurnedTheWrongWay) {
  const std::vector<Box> world = yard();
  LoopVerifier loops = verifier();
  loops.setTarget(targetOf(world, {kPlace}));
  const Pose T = poseFromYaw(0.1, {1, 0.5, 0});
  OdometryPrediction lost = near(T);
  lost.T_match_query = T * poseFromYaw(M_PI, {0, 0, 0});  // no help: turned like the guess
  lost.path_covariance(5, 5) = 10;
  const Verification verdict = loops.verify(scanAt(world, kPlace * T), {lost.T_match_query}, lost, false);
  EXPECT_THAT(verdict.registration.T_target_source, IsNear(T, 0.005, 0.05));
}

TEST(LoopVerifier, TriesOdometrysPoseToo) {
  const std::vector<Box> world = yard();
  LoopVerifier loops = verifier();
  loops.setTarget(targetOf(world, {kPlace}));
  const Pose T = poseFromYaw(0.1, {5, 3, 0});
  const Verification verdict =
      loops.verify(scanAt(world, kPlace * T), {poseFromYaw(0.1 + M_PI / 2, Eigen::Vector3d::Zero())}, near(T), false);
  EXPECT_EQ(verdict.refusal, "");
  EXPECT_THAT(verdict.registration.T_target_source, IsNear(T, 0.005, 0.05));
}

TEST(LoopVerifier, AScanMustNotSeeThroughTheSubmapsWalls) {
  // Where the submap was made stands a screen that the scan's place does not have; everything else is the same.
  std::vector<Box> screened = yard();
  screened.push_back({{3, -3, 0}, {3.4, 12, 9}});
  const Pose T = poseFromYaw(0.05, {0.5, 0.2, 0});
  LoopVerifier loops = verifier();
  loops.setTarget(targetOf(screened, {kPlace}));
  const Verification through = loops.verify(scanAt(yard(), kPlace * T), {T}, near(T), false);
  EXPECT_THAT(through.refusal, HasSubstr("free space: the scan sees through"));
  EXPECT_GT(through.free_space->through_submap, 0.05);
  // And the reverse: the scan has a wall where the submap's scans looked through.
  loops.setTarget(targetOf(yard(), {kPlace}));
  const Verification wall = loops.verify(scanAt(screened, kPlace * T), {T}, near(T), false);
  EXPECT_THAT(wall.refusal, HasSubstr("free space: the submap sees through"));
}

TEST(LoopVerifier, ACorridorFixesFiveAxesAndTheFactorKeepsOnlyThose) {
  const std::vector<Box> corridor = {{{-500, -2, 0}, {500, 2.5, 3}}};
  const Pose place = poseFromYaw(0, {0, 0.2, 1.2}), T = poseFromYaw(0.02, {2.0, 0.3, 0.0});
  LoopVerifier loops = verifier();
  loops.setTarget(targetOf(corridor, {place, place * poseFromYaw(0, {1, 0, 0})}));
  OdometryPrediction predicted;
  predicted.T_match_query = T * poseFromYaw(0.01, {0.8, 0.15, 0.05});
  predicted.travelled_m = 100;
  const Verification verdict =
      loops.verify(scanAt(corridor, place * T), {poseFromYaw(0, Eigen::Vector3d::Zero())}, predicted, false);
  EXPECT_EQ(verdict.refusal, "");
  EXPECT_EQ(verdict.registration.degenerate_axes, 1);
  const Eigen::Vector3d t = verdict.registration.T_target_source.translation();
  EXPECT_NEAR(t.x(), predicted.T_match_query.translation().x(), 0.1) << "odometry's: the walls say nothing";
  EXPECT_NEAR(t.y(), 0.3, 0.01);
  EXPECT_NEAR(yawOf(verdict.registration.T_target_source), 0.02, 0.001);
  const Matrix6d& information = verdict.registration.hessian;
  const Eigen::Vector3d along = verdict.registration.T_target_source.linear().transpose() * Eigen::Vector3d::UnitX(),
                        across = verdict.registration.T_target_source.linear().transpose() * Eigen::Vector3d::UnitY();
  EXPECT_LT(along.dot(information.topLeftCorner<3, 3>() * along), 0.1);
  EXPECT_GT(across.dot(information.topLeftCorner<3, 3>() * across), 100);
}

TEST(LoopVerifier, APlaceThatLooksAlikeFromBothEndsIsAmbiguousUnlessOdometryKnows) {
  // Every box has its mirror image through the centre.
  const std::vector<Box> hall = {{{-30, -20, 0}, {30, 20, 12}},
                                 {{-18, 6, 0}, {-9, 14, 7}},
                                 {{9, -14, 0}, {18, -6, 7}},
                                 {{4, 9, 0}, {10, 12, 5}},
                                 {{-10, -12, 0}, {-4, -9, 5}}};
  const Pose place = poseFromYaw(0, {0, 0, 1.7}), T = poseFromYaw(0.05, {0.4, 0.3, 0});
  LoopVerifier loops = verifier();
  loops.setTarget(targetOf(hall, {place, place * poseFromYaw(0.1, {1, 0, 0}), place * poseFromYaw(-0.1, {-1, 0, 0})}));
  OdometryPrediction predicted;
  predicted.T_match_query = T * poseFromYaw(0.02, {0.2, -0.1, 0.03});
  predicted.travelled_m = 20;
  const Cloud scan = scanAt(hall, place * T);
  EXPECT_EQ(loops.verify(scan, {T}, predicted, false).refusal, "") << "after 20 m odometry knows front from back";
  predicted.path_covariance.diagonal() << 9, 9, 1, 0.01, 0.01, 4;
  EXPECT_THAT(loops.verify(scan, {T}, predicted, false).refusal, HasSubstr("180 deg away fits"));
}

TEST(LoopVerifier, PlanarScansAreJudgedByTheSameGates) {
  const auto flat = [](Cloud cloud) {
    std::fill(cloud.z.begin(), cloud.z.end(), 0.0f);
    return cloud;
  };
  const std::vector<Box> room = {{{-5, -4, 0}, {6, 3, 3}}, {{-2, 1, 0}, {-1, 3, 3}}, {{2, -4, 0}, {2.6, -2.2, 3}}};
  std::vector<Box> screened = room;
  screened.push_back({{3, -1, 0}, {3.1, 2, 3}});
  const Pose place = poseFromYaw(0.3, {0, 0, 1}), T = poseFromYaw(2.9, {0.4, -0.3, 0});
  const auto single = [&](const std::vector<Box>& world, const Pose& T_world_base) {
    return flat(scanAt(world, T_world_base, 1, 720));
  };
  const auto target = [&](const std::vector<Box>& world) {
    const auto scan = std::make_shared<Cloud>(single(world, place));
    return LoopTarget{*scan, {Pose::Identity()}, {scan}};
  };
  OdometryPrediction predicted;
  predicted.T_match_query = T * poseFromYaw(0.05, {0.2, 0.1, 0});
  predicted.travelled_m = 40;
  LoopVerifier loops = verifier();
  loops.setTarget(target(room));
  const Verification same = loops.verify(single(room, place * T), {T}, predicted, true);
  EXPECT_EQ(same.refusal, "");
  EXPECT_THAT(same.registration.T_target_source, IsNear(T, 0.01, 0.2));
  loops.setTarget(target(screened));
  EXPECT_NE(loops.verify(single(room, place * T), {T}, predicted, true).refusal, "");
}

TEST(LoopVerifier, EmptyAndHostileCloudsAreRefusedWithAReason) {
  Cloud nans;
  for (int i = 0; i < 500; ++i) nans.push(std::numeric_limits<float>::quiet_NaN(), 1, 1);
  LoopVerifier loops = verifier();
  EXPECT_NE(loops.verify(scanAt(yard(), kPlace), {Pose::Identity()}, {}, false).refusal, "") << "no target";
  for (const Cloud& bad : {Cloud{}, nans}) {
    loops.setTarget({bad, {Pose::Identity()}, {std::make_shared<Cloud>(bad)}});
    EXPECT_NE(loops.verify(scanAt(yard(), kPlace), {Pose::Identity()}, {}, false).refusal, "");
    loops.setTarget(targetOf(yard(), {kPlace}));
    EXPECT_NE(loops.verify(bad, {Pose::Identity()}, {}, false).refusal, "");
  }
}

}  // namespace
}  // namespace scslam
