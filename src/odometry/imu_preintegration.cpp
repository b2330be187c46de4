#include "scslam/odometry/imu_preintegration.h"

#include <cmath>

namespace scslam {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void ImuNoise::describe(ParamVisitor& visitor) {
  visitor.field("gyro", gyro, "white noise of the rates [rad/s/sqrt(Hz)]", 1e-8, 10.0);
  visitor.field("accel", accel, "white noise of the accelerations [m/s^2/sqrt(Hz)]", 1e-8, 100.0);
  visitor.field("gyro_walk", gyro_walk, "random walk of the rates' bias [rad/s^2/sqrt(Hz)]", 0.0, 1.0);
  visitor.field("accel_walk", accel_walk, "random walk of the accelerations' bias [m/s^3/sqrt(Hz)]", 0.0, 10.0);
}

namespace {

/// Exp(v + d) = Exp(v) Exp(J_r(v) d) + o(d).
Matrix3d so3RightJacobian(const Vector3d& v) {
  const double angle2 = v.squaredNorm();
  double a, b;  // (1 - cos) / angle^2, (angle - sin) / angle^3
  if (angle2 < 1e-8) {
    a = 0.5 - angle2 / 24;
    b = 1.0 / 6 - angle2 / 120;
  } else {
    const double angle = std::sqrt(angle2);
    a = (1 - std::cos(angle)) / angle2;
    b = (angle - std::sin(angle)) / (angle2 * angle);
  }
  const Matrix3d W = skew(v);
  return Matrix3d::Identity() - a * W + b * W * W;
}

/// Turn during h seconds from rate w0 to rate w1. Two terms of the Magnus expansion for a rate linear in time.
Vector3d turn(const Vector3d& w0, const Vector3d& w1, double h) {
  return 0.5 * h * (w0 + w1) + h * h / 12 * w0.cross(w1);
}
/// Derivative of turn() when both rates change by the same.
Matrix3d turnByRate(const Vector3d& w0, const Vector3d& w1, double h) {
  return h * Matrix3d::Identity() + h * h / 12 * skew(w0 - w1);
}

/// Readings of a segment without bias, and its rotation half way and at the end.
struct Segment {
  double h;
  Vector3d w0, w1, wm, f0, f1, fm, half_turn, full_turn;
  Matrix3d Rm, R1;

  Segment(const ImuReading& a, const ImuReading& b, const ImuBias& bias)
      : h(b.t - a.t),
        w0(a.gyro - bias.gyro),
        w1(b.gyro - bias.gyro),
        wm(0.5 * (w0 + w1)),
        f0(a.accel - bias.accel),
        f1(b.accel - bias.accel),
        fm(0.5 * (f0 + f1)),
        half_turn(turn(w0, wm, 0.5 * h)),
        full_turn(turn(w0, w1, h)),
        Rm(so3Exp(half_turn)),
        R1(so3Exp(full_turn)) {}

  ImuMotion motion() const { return {h, R1, h / 6 * (f0 + 4 * (Rm * fm) + R1 * f1), h * h / 6 * (f0 + 2 * (Rm * fm))}; }
};

}  // namespace

ImuMotion ImuMotion::then(const ImuMotion& next) const {
  return {duration_s + next.duration_s, dR * next.dR, dv + dR * next.dv, dp + dv * next.duration_s + dR * next.dp};
}

ImuMotion motionBetween(const ImuReading& a, const ImuReading& b, const ImuBias& bias) {
  return Segment(a, b, bias).motion();
}

NavState NavState::after(const ImuMotion& m, const Vector3d& gravity) const {
  NavState next;
  next.R = R * m.dR;
  next.v = v + gravity * m.duration_s + R * m.dv;
  next.p = p + v * m.duration_s + 0.5 * m.duration_s * m.duration_s * gravity + R * m.dp;
  return next;
}

ImuPreintegration::ImuPreintegration(const std::vector<ImuReading>& readings, const ImuBias& bias,
                                     const ImuNoise& noise)
    : readings_(readings), bias_(bias) {
  for (std::size_t i = 0; i + 1 < readings.size(); ++i)
    if (readings[i + 1].t > readings[i].t) add(readings[i], readings[i + 1], noise);
}

void ImuPreintegration::add(const ImuReading& a, const ImuReading& b, const ImuNoise& noise) {
  const Segment s(a, b, bias_);
  const ImuMotion step = s.motion();
  const double h = s.h;
  const Matrix3d& R = motion_.dR;

  // Derivatives of the step alone by rates and forces (a bias enters with the opposite sign).
  const Matrix3d Rm_by_w = -s.Rm * skew(s.fm) * so3RightJacobian(s.half_turn) * turnByRate(s.w0, s.wm, 0.5 * h);
  const Matrix3d turn_by_w = so3RightJacobian(s.full_turn) * turnByRate(s.w0, s.w1, h);
  const Matrix3d R1_by_w = -s.R1 * skew(s.f1) * turn_by_w;
  const Matrix3d v_by_w = h / 6 * (4 * Rm_by_w + R1_by_w), p_by_w = h * h / 3 * Rm_by_w;
  const Matrix3d v_by_f = h / 6 * (Matrix3d::Identity() + 4 * s.Rm + s.R1);
  const Matrix3d p_by_f = h * h / 6 * (Matrix3d::Identity() + 2 * s.Rm);

  // What an error of the rotation so far does to the step.
  const Matrix3d v_by_R = -R * skew(step.dv), p_by_R = -R * skew(step.dp);

  dp_dgyro += h * dv_dgyro + p_by_R * dR_dgyro - R * p_by_w;
  dp_daccel += h * dv_daccel - R * p_by_f;
  dv_dgyro += v_by_R * dR_dgyro - R * v_by_w;
  dv_daccel += -R * v_by_f;
  dR_dgyro = (step.dR.transpose() * dR_dgyro - turn_by_w).eval();

  Matrix9d A = Matrix9d::Identity();
  A.block<3, 3>(0, 3) = p_by_R;
  A.block<3, 3>(0, 6) = h * Matrix3d::Identity();
  A.block<3, 3>(3, 3) = step.dR.transpose();
  A.block<3, 3>(6, 3) = v_by_R;
  Eigen::Matrix<double, 9, 6> B;
  B << R * p_by_w, R * p_by_f, turn_by_w, Matrix3d::Zero(), R * v_by_w, R * v_by_f;
  Eigen::Matrix<double, 6, 1> variance;
  variance << Vector3d::Constant(noise.gyro * noise.gyro / h), Vector3d::Constant(noise.accel * noise.accel / h);
  covariance = (A * covariance * A.transpose() + B * variance.asDiagonal() * B.transpose()).eval();

  motion_ = motion_.then(step);
}

ImuMotion ImuPreintegration::motion(const ImuBias& bias) const {
  const Vector3d dw = bias.gyro - bias_.gyro, df = bias.accel - bias_.accel;
  ImuMotion m = motion_;
  m.dR = motion_.dR * so3Exp(dR_dgyro * dw);
  m.dv += dv_dgyro * dw + dv_daccel * df;
  m.dp += dp_dgyro * dw + dp_daccel * df;
  return m;
}

}  // namespace scslam
