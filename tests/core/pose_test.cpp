#include "scslam/core/pose.h"

#include <random>

#include "scslam/core/mrpt_pose.h"
#include "support/support.h"

namespace scslam {
namespace {

using test::IsNear;

class Random {
 public:
  double operator()(double scale = 1) { return scale * (static_cast<double>(engine_()) / 2147483648.0 - 1); }
  Vector6d tangent(double trans, double rot) {
    Vector6d d;
    for (int i = 0; i < 6; ++i) d(i) = (*this)(i < 3 ? trans : rot);
    return d;
  }
  Pose pose() { return retract(Pose::Identity(), tangent(20, 1.7)); }

 private:
  std::mt19937 engine_{7};
};

TEST(Pose, LocalInvertsRetractForAnyMotionBelowHalfATurn) {
  Random random;
  for (int i = 0; i < 200; ++i) {
    const Pose T = random.pose();
    const Vector6d d = random.tangent(5, 1.8);
    EXPECT_LT((local(T, retract(T, d)) - d).norm(), 1e-12);
  }
}

TEST(Pose, LogIsExactAtTinyAnglesAndAtHalfATurn) {
  for (const double angle : {1e-12, 1e-7, 1e-4, 1.0, M_PI - 1e-7, M_PI}) {
    const Eigen::Vector3d v = angle * Eigen::Vector3d(1, -2, 3).normalized();
    const Eigen::Vector3d back = so3Log(so3Exp(v));
    EXPECT_LT(std::min((back - v).norm(), (back + v).norm()), 1e-12) << angle;
  }
}

TEST(Pose, RightJacobianInverseAgreesWithNumericDerivative) {
  Random random;
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d v = random.tangent(1, 1.5).tail<3>();
    const Eigen::Matrix3d J = so3RightJacobianInverse(v);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d e = 1e-6 * Eigen::Vector3d::Unit(k);
      const Eigen::Vector3d numeric = (so3Log(so3Exp(v) * so3Exp(e)) - so3Log(so3Exp(v) * so3Exp(-e))) / 2e-6;
      EXPECT_LT((numeric - J.col(k)).norm(), 1e-8);
    }
  }
}

TEST(Pose, AdjointMovesASmallStepThroughATransform) {
  Random random;
  const Pose T = random.pose();
  const Vector6d d = random.tangent(1e-5, 1e-5);
  const Pose left = T * retract(Pose::Identity(), d);
  const Pose right = retract(Pose::Identity(), adjoint(T) * d) * T;
  EXPECT_LT(local(left, right).norm(), 1e-8);
}

TEST(Pose, ComposedCovarianceAgreesWithMonteCarlo) {
  Random random;
  const Pose T_b_c = retract(Pose::Identity(), random.tangent(3, 0.5));
  const Matrix6d A = 1e-6 * Vector6d(1, 2, 3, 4, 5, 6).asDiagonal().toDenseMatrix();
  const Matrix6d B = 1e-6 * Vector6d(2, 1, 2, 1, 2, 1).asDiagonal().toDenseMatrix();
  const Matrix6d composed = composeCovariance(A, T_b_c, B);
  std::mt19937 engine(3);
  std::normal_distribution<double> normal;
  Matrix6d sampled = Matrix6d::Zero();
  constexpr int kSamples = 40000;
  for (int s = 0; s < kSamples; ++s) {
    Vector6d a, b;
    for (int i = 0; i < 6; ++i) a(i) = std::sqrt(A(i, i)) * normal(engine), b(i) = std::sqrt(B(i, i)) * normal(engine);
    const Vector6d d = local(T_b_c, retract(Pose::Identity(), a) * retract(T_b_c, b));
    sampled += d * d.transpose() / kSamples;
  }
  EXPECT_LT((sampled - composed).norm() / composed.norm(), 0.03);
}

TEST(Pose, InterpolationMeetsBothEndsAndTheMiddle) {
  const Pose A = poseFromYaw(0.2, {1, 2, 3}), B = poseFromYaw(1.0, {3, 2, 1});
  EXPECT_THAT(interpolate(A, B, 0), IsNear(A, 1e-12, 1e-6));
  EXPECT_THAT(interpolate(A, B, 1), IsNear(B, 1e-12, 1e-6));
  EXPECT_THAT(interpolate(A, B, 0.5), IsNear(poseFromYaw(0.6, {2, 2, 2}), 1e-12, 1e-6));
}

TEST(Pose, NoisyRotationIsMadeExactAndMirrorsAreRefused) {
  Pose T = poseFromYaw(0.3, {1, 2, 3});
  T.linear()(0, 1) += 1e-4;
  EXPECT_LT(
      (orthonormalised(T).linear() * orthonormalised(T).linear().transpose() - Eigen::Matrix3d::Identity()).norm(),
      1e-12);
  Pose mirror = Pose::Identity();
  mirror.linear()(2, 2) = -1;
  EXPECT_FALSE(isRigid(mirror));
  EXPECT_TRUE(isRigid(poseFromYaw(2, {0, 0, 0})));
}

TEST(MrptPose, MeanSurvivesTheRoundTripAndMapsPointsAlike) {
  Random random;
  for (int i = 0; i < 50; ++i) {
    const Pose T = random.pose();
    EXPECT_THAT(fromMrpt(toMrpt(T)), IsNear(T, 1e-12, 1e-6));
    double gx, gy, gz;
    toMrpt(T).composePoint(1, 2, 3, gx, gy, gz);
    EXPECT_LT((T * Eigen::Vector3d(1, 2, 3) - Eigen::Vector3d(gx, gy, gz)).norm(), 1e-12);
  }
}

TEST(MrptPose, EveryInformationBlockMeansTheSameUncertainty) {
  // The same small displacement must cost the same in both parametrisations, block by block.
  Random random;
  const Pose T = retract(Pose::Identity(), random.tangent(3, 0.6));
  for (int a = 0; a < 6; ++a) {
    for (int b = a; b < 6; ++b) {
      Matrix6d information = Matrix6d::Identity() * 10;
      information(a, b) = information(b, a) = a == b ? 40 : 4;
      const auto pdf = toMrpt(T, information);
      const Vector6d d = random.tangent(1e-5, 1e-5);
      const auto moved = toMrpt(retract(T, d));
      Vector6d dm;
      dm << moved.x() - pdf.mean.x(), moved.y() - pdf.mean.y(), moved.z() - pdf.mean.z(), moved.yaw() - pdf.mean.yaw(),
          moved.pitch() - pdf.mean.pitch(), moved.roll() - pdf.mean.roll();
      double cost = 0;
      for (int r = 0; r < 6; ++r)
        for (int c = 0; c < 6; ++c) cost += dm(r) * pdf.cov_inv(r, c) * dm(c);
      const double expected = d.dot(information * d);
      EXPECT_NEAR(cost / expected, 1, 1e-3) << "block " << a << "," << b;
      Pose mean;
      Matrix6d back;
      fromMrpt(pdf, mean, back);
      EXPECT_LT((back - information).norm(), 1e-9 * information.norm());
    }
  }
}

}  // namespace
}  // namespace scslam
