// Well laid on each other or not, told by figures.
#include "scslam/registration/alignment_quality.h"

#include "scslam/apps/learn/logistic.h"
#include "scslam/core/counter_random.h"
#include "scslam/core/error.h"
#include "support/support.h"

namespace scslam::test {
namespace {

using ::testing::HasSubstr;

/// A street of two walls and some poles, seen with noise.
Cloud street(std::uint64_t seed) {
  RandomSequence random(CounterRandom(seed, RandomStream::kWorld));
  Cloud cloud;
  const auto put = [&](double x, double y) {
    cloud.push(static_cast<float>(x + 0.05 * random.normal()), static_cast<float>(y + 0.05 * random.normal()), 0.0F);
  };
  for (double x = -20; x <= 20; x += 0.2) put(x, 4), put(x, -5);
  for (double x = -18; x <= 18; x += 6)
    for (int i = 0; i < 8; ++i) put(x, 2.5), put(x + 2, -3);
  return cloud;
}

AlignmentFeatures featuresAt(const Pose& T_target_source, bool planar = true) {
  RegistrationResult result;
  result.T_target_source = T_target_source;
  result.rmse_m = 0.07;
  return alignmentFeatures(street(1), street(2), result, 1.5, planar);
}

TEST(AlignmentQuality, ScansLaidWrongBlur) {
  for (const bool planar : {true, false}) {
    const AlignmentFeatures right = featuresAt(Pose::Identity(), planar);
    EXPECT_NEAR(right.blur, 0, 0.1);
    EXPECT_GT(right.shared, 0.98);
    EXPECT_EQ(right.rmse_m, 0.07);
    const double aside = featuresAt(poseFromYaw(0, {0, 0.8, 0}), planar).blur,
                 turned = featuresAt(poseFromYaw(0.05, {0, 0, 0}), planar).blur;
    EXPECT_GT(aside, right.blur + 0.3);
    EXPECT_GT(turned, right.blur + 0.1);
  }
  EXPECT_LT(featuresAt(poseFromYaw(0, {0, 30, 0})).shared, 0.05) << "nothing of the street is there";
}

TEST(AlignmentQuality, SaysWhatItDoesNotBelieve) {
  QualityParams params;
  params.bias = 2, params.blur = -10;
  AlignmentFeatures sharp, blurred;
  blurred.blur = 0.5;
  EXPECT_NEAR(probabilityOf(sharp, params), 1 / (1 + std::exp(-2.0)), 1e-12);
  EXPECT_EQ(refusal(blurred, params), "") << "not asked";
  params.on = true;
  EXPECT_EQ(refusal(sharp, params), "");
  EXPECT_THAT(refusal(blurred, params), HasSubstr("alignment quality 0.05 < 0.50 (blur 0.50"));
}

TEST(AlignmentQuality, EmptyScansHaveNoFeatures) {
  const AlignmentFeatures nothing = alignmentFeatures(Cloud(), Cloud(), {}, 1.5, true);
  EXPECT_EQ(nothing.blur, 0);
  EXPECT_EQ(nothing.shared, 0);
}

/// Examples drawn from known weights give these weights back.
TEST(Logistic, FindsTheWeightsThatMadeTheExamples) {
  RandomSequence random(CounterRandom(3, RandomStream::kWorld));
  const Eigen::Vector3d truth(0, 2, -0.5);  // bias first
  Examples examples;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector2d x(random.normal(), 4 * random.normal());
    examples.features.push_back(x);
    examples.yes.push_back(random.uniform() < logisticProbability(truth, x));
  }
  const Eigen::VectorXd w = logisticWeights(examples);
  ASSERT_EQ(w.size(), 3);
  EXPECT_NEAR(w(0), truth(0), 0.1);
  EXPECT_NEAR(w(1), truth(1), 0.1);
  EXPECT_NEAR(w(2), truth(2), 0.05);
}

TEST(Logistic, SeparableExamplesAreNoTroubleAndOneClassIs) {
  Examples examples;
  for (int i = 0; i < 40; ++i) {
    examples.features.push_back(Eigen::VectorXd::Constant(1, i));
    examples.yes.push_back(i >= 20);
  }
  const Eigen::VectorXd w = logisticWeights(examples);
  EXPECT_TRUE(w.allFinite());
  EXPECT_EQ(areaUnderRoc(w, examples), 1.0);
  examples.yes.assign(40, true);
  EXPECT_THROW(logisticWeights(examples), Error);
}

}  // namespace
}  // namespace scslam::test
