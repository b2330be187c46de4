#include "scslam/core/mrpt_pose.h"

#include <cmath>

namespace scslam {
namespace {

/// d(x y z yaw pitch roll) / d(our tangent) at T: t moves by R * d_trans; the Euler angles of R = Rz(yaw) Ry(pitch)
/// Rx(roll) move with the body rates d_rot.
Matrix6d mrptFromTangent(const Pose& T, double pitch, double roll) {
  Matrix6d J = Matrix6d::Zero();
  J.topLeftCorner<3, 3>() = T.linear();
  const double sr = std::sin(roll), cr = std::cos(roll), cp = std::cos(pitch), tp = std::tan(pitch);
  Eigen::Matrix3d E;
  E << 0, sr / cp, cr / cp,  // yaw
      0, cr, -sr,            // pitch
      1, sr * tp, cr * tp;   // roll
  J.bottomRightCorner<3, 3>() = E;
  return J;
}

}  // namespace

mrpt::poses::CPose3D toMrpt(const Pose& T) {
  mrpt::math::CMatrixDouble44 M;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c) M(r, c) = T.matrix()(r, c);
  return mrpt::poses::CPose3D(M);
}

Pose fromMrpt(const mrpt::poses::CPose3D& pose) {
  const auto M = pose.getHomogeneousMatrixVal<mrpt::math::CMatrixDouble44>();
  Pose T = Pose::Identity();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) T.matrix()(r, c) = M(r, c);
  return T;
}

mrpt::poses::CPose3DPDFGaussianInf toMrpt(const Pose& mean, const Matrix6d& information) {
  mrpt::poses::CPose3DPDFGaussianInf pdf;
  pdf.mean = toMrpt(mean);
  const Matrix6d J_inverse = mrptFromTangent(mean, pdf.mean.pitch(), pdf.mean.roll()).inverse();
  const Matrix6d inf = J_inverse.transpose() * information * J_inverse;
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < 6; ++c) pdf.cov_inv(r, c) = 0.5 * (inf(r, c) + inf(c, r));
  return pdf;
}

void fromMrpt(const mrpt::poses::CPose3DPDFGaussianInf& pdf, Pose& mean, Matrix6d& information) {
  mean = fromMrpt(pdf.mean);
  const Matrix6d J = mrptFromTangent(mean, pdf.mean.pitch(), pdf.mean.roll());
  Matrix6d inf;
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < 6; ++c) inf(r, c) = pdf.cov_inv(r, c);
  information = J.transpose() * inf * J;
}

}  // namespace scslam
