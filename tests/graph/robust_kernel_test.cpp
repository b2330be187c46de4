#include "scslam/graph/robust_kernel.h"

#include <gtest/gtest.h>

namespace scslam {
namespace {

class RobustKernels : public ::testing::TestWithParam<KernelKind> {};

TEST_P(RobustKernels, WeighHalfAtTheGate) {
  const RobustKernel kernel(GetParam(), 16.8);
  EXPECT_NEAR(kernel(16.8).weight, 0.5, 1e-12);
  EXPECT_GT(kernel(16.7).weight, 0.5);
  EXPECT_NEAR(kernel(0).weight, 1, 1e-12);
  EXPECT_EQ(kernel(0).rho, 0);
}

TEST_P(RobustKernels, WeightIsTheDerivativeOfTheCost) {
  const RobustKernel kernel(GetParam(), 16.8);
  for (const double s : {0.5, 3.0, 10.0, 16.8, 50.0, 1e4}) {
    const double h = 1e-5 * s;
    EXPECT_NEAR((kernel(s + h).rho - kernel(s - h).rho) / (2 * h), kernel(s).weight, 1e-6) << s;
  }
}

INSTANTIATE_TEST_SUITE_P(All, RobustKernels,
                         ::testing::Values(KernelKind::kHuber, KernelKind::kCauchy, KernelKind::kDcs,
                                           KernelKind::kGemanMcClure));

TEST(TruncatedWeight, TurnsIntoAStepAtTheGate) {
  EXPECT_EQ(truncatedWeight(9, 10, 1e6), 1);
  EXPECT_EQ(truncatedWeight(11, 10, 1e6), 0);
  const double middle = truncatedWeight(10, 10, 1);
  EXPECT_GT(middle, 0);
  EXPECT_LT(middle, 1);
}

}  // namespace
}  // namespace scslam
