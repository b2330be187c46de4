#include "scslam/apps/nees.h"

#include <random>

#include "support/support.h"

namespace scslam {
namespace {

using ::testing::DoubleNear;
using ::testing::Optional;

struct Walk {
  std::vector<Keyframe> keyframes;
  std::vector<std::optional<Pose>> truth;
};

double gauss(std::mt19937& random) {  // Box and Muller: the same numbers with every standard library
  const auto uniform = [&] { return (static_cast<double>(random()) + 0.5) / 4294967296.0; };
  return std::sqrt(-2 * std::log(uniform())) * std::cos(2 * M_PI * uniform());
}

/// Steps whose errors are drawn from `covariance` (a full one), and which claim `claimed` times as much.
Walk walk(std::size_t steps, double claimed, bool planar = false) {
  std::mt19937 random(3);
  Matrix6d L = 0.02 * Matrix6d::Identity();
  for (int i = 1; i < 6; ++i) L(i, i - 1) = 0.015;
  if (planar) L = (Vector6d() << 0.02, 0.03, 1, 1, 1, 0.01).finished().asDiagonal();
  Walk result;
  Pose T_truth = Pose::Identity(), T_odom = Pose::Identity();
  for (std::size_t k = 0; k <= steps; ++k) {
    Keyframe keyframe;
    keyframe.T_odom_base = T_odom;
    if (k > 0) keyframe.step_covariance = claimed * L * L.transpose();
    result.keyframes.push_back(keyframe);
    result.truth.emplace_back(T_truth);
    Vector6d error;
    for (int i = 0; i < 6; ++i) error(i) = gauss(random);
    error = L * error;
    const Pose step = poseFromYaw(0.3, {1, 0.2, 0});
    if (planar) error(2) = error(3) = error(4) = 0;
    T_truth = T_truth * step;
    T_odom = T_odom * retract(step, error);
  }
  return result;
}

TEST(StepNees, AnHonestCovarianceLiesInTheBand) {
  const Walk w = walk(2000, 1);
  const StepConsistency s = stepConsistency(w.keyframes, w.truth, false);
  EXPECT_EQ(s.steps, 2000u);
  EXPECT_THAT(s.mean, Optional(DoubleNear(6, 0.2)));
  EXPECT_GT(*s.mean, s.low);
  EXPECT_LT(*s.mean, s.high);
  EXPECT_NEAR(s.high - s.low, 2 * 1.96 * std::sqrt(12.0 / 2000), 0.005) << "variance of chi-square: 2 x 6";
  EXPECT_THAT(s.inside_95, Optional(DoubleNear(0.95, 0.015)));
  for (const double ratio : s.axis_ratio) EXPECT_NEAR(ratio, 1, 0.05);
}

TEST(StepNees, ScalesWithTheClaim) {
  const auto mean = [](double claimed) {
    const Walk w = walk(400, claimed);
    return *stepConsistency(w.keyframes, w.truth, false).mean;
  };
  EXPECT_NEAR(mean(0.25), 4 * mean(1), 1e-6);
  EXPECT_NEAR(mean(4), mean(1) / 4, 1e-6);
}

TEST(StepNees, NamesTheAxisThatLies) {
  Walk w = walk(500, 1);
  for (Keyframe& keyframe : w.keyframes) keyframe.step_covariance(5, 5) *= 9;
  const StepConsistency s = stepConsistency(w.keyframes, w.truth, false);
  EXPECT_NEAR(s.axis_ratio[5], 1.0 / 3, 0.03);
  EXPECT_NEAR(s.axis_ratio[0], 1, 0.1);
}

TEST(StepNees, PlanarDataCountsThreeAxes) {
  const Walk w = walk(2000, 1, true);
  const StepConsistency s = stepConsistency(w.keyframes, w.truth, true);
  EXPECT_EQ(s.dimensions, 3);
  EXPECT_THAT(s.mean, Optional(DoubleNear(3, 0.15)));
}

TEST(StepNees, SingularCovariancesAndMissingTruthAreCountedApart) {
  Walk w = walk(10, 1);
  w.keyframes[3].step_covariance.setZero();
  w.keyframes[4].step_covariance(0, 0) = std::nan("");
  w.truth[9].reset();  // two steps end there
  const StepConsistency s = stepConsistency(w.keyframes, w.truth, false);
  EXPECT_EQ(s.steps, 8u);
  EXPECT_EQ(s.singular, 2u);
  EXPECT_TRUE(s.mean && std::isfinite(*s.mean));
  EXPECT_FALSE(stepConsistency({}, {}, false).mean);
}

TEST(ChiSquare, QuantilesOfTheTables) {
  EXPECT_NEAR(chiSquareQuantile(6, 1.6448536), 12.592, 0.03);
  EXPECT_NEAR(chiSquareQuantile(3, 1.6448536), 7.815, 0.05);
  EXPECT_NEAR(chiSquareQuantile(100, 1.959964), 129.561, 0.02);
  EXPECT_NEAR(chiSquareQuantile(100, -1.959964), 74.222, 0.02);
}

}  // namespace
}  // namespace scslam
