#include "scslam/odometry/imu_filter.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

namespace scslam {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kFloor = 1e-8;  // [m^2, rad^2]

template <class Matrix>
void symmetrise(Matrix& M) {
  M = (0.5 * (M + M.transpose())).eval();
}

/// (S + information^-1)^-1, also where the information is singular.
Matrix6d weightOf(const Matrix6d& S, const Matrix6d& information) {
  Matrix6d W = information * (Matrix6d::Identity() + S * information).inverse();
  symmetrise(W);
  return W;
}

Pose poseOf(const NavState& nav) {
  Pose T = Pose::Identity();
  T.linear() = nav.R;
  T.translation() = nav.p;
  return T;
}

Matrix3d renormalised(const Matrix3d& R) { return Eigen::Quaterniond(R).normalized().toRotationMatrix(); }

}  // namespace

void ImuFilter::begin(const Pose& T_odom_base, const Pose& T_base_imu, const Vector3d& gravity,
                      const Vector3d& velocity, const Start& start) {
  const Pose T_odom_imu = T_odom_base * T_base_imu;
  nav_ = {T_odom_imu.linear(), T_odom_imu.translation(), velocity};
  bias_ = {};
  gravity_ = gravity;
  T_base_imu_ = T_base_imu;
  Vector sigma = Vector::Zero();
  sigma.segment<3>(kV).setConstant(start.velocity_mps);
  sigma.segment<3>(kGyroBias).setConstant(start.gyro_bias);
  sigma.segment<3>(kAccelBias).setConstant(start.accel_bias);
  sigma.segment<2>(kGravity).setConstant(start.gravity_rad);
  sigma.segment<3>(kMounting).setConstant(start.mounting_m);
  sigma.segment<3>(kMounting + 3).setConstant(start.mounting_rad);
  P_ = sigma.cwiseAbs2().asDiagonal();
  beginStep();
}

void ImuFilter::apply(const Vector& error) {
  nav_.p += error.segment<3>(kP);
  nav_.R = renormalised(nav_.R * so3Exp(error.segment<3>(kTheta)));
  nav_.v += error.segment<3>(kV);
  bias_.gyro += error.segment<3>(kGyroBias);
  bias_.accel += error.segment<3>(kAccelBias);
  gravity_ = turnedGravity(gravity_, error.segment<2>(kGravity));
  T_base_imu_ = retract(T_base_imu_, error.segment<6>(kMounting));
  T_base_imu_.linear() = renormalised(T_base_imu_.linear());
}

Pose ImuFilter::basePose() const { return poseOf(nav_) * T_base_imu_.inverse(); }

ImuFilter::Jacobian6 ImuFilter::baseJacobian() const {
  // T_odom_imu Exp(d_imu) (T_base_imu Exp(d_mounting))^-1 = T_odom_base Exp(Ad(T_base_imu) (d_imu - d_mounting))
  const Matrix6d A = adjoint(T_base_imu_);
  Jacobian6 J = Jacobian6::Zero();
  J.block<6, 3>(0, kP) = A.leftCols<3>() * nav_.R.transpose();
  J.block<6, 3>(0, kTheta) = A.rightCols<3>();
  J.block<6, 6>(0, kMounting) = -A;
  return J;
}

void ImuFilter::beginStep() {
  const Jacobian6 J = baseJacobian();
  T_clone_ = basePose();
  cross_ = J * P_;
  clone_ = cross_ * J.transpose();
  symmetrise(clone_);
}

ImuFilter::Covariance ImuFilter::transition(const ImuPreintegration& imu) const {
  const ImuMotion m = imu.motion(bias_);
  const double T = m.duration_s;
  const Matrix3d I = Matrix3d::Identity();
  const Eigen::Matrix<double, 3, 2> B = gravityByAngles(gravity_);
  Covariance F = Covariance::Identity();
  F.block<3, 3>(kP, kTheta) = -nav_.R * skew(m.dp);
  F.block<3, 3>(kP, kV) = T * I;
  F.block<3, 3>(kP, kGyroBias) = nav_.R * imu.dp_dgyro;
  F.block<3, 3>(kP, kAccelBias) = nav_.R * imu.dp_daccel;
  F.block<3, 2>(kP, kGravity) = 0.5 * T * T * B;
  F.block<3, 3>(kTheta, kTheta) = m.dR.transpose();
  F.block<3, 3>(kTheta, kGyroBias) = imu.dR_dgyro;
  F.block<3, 3>(kV, kTheta) = -nav_.R * skew(m.dv);
  F.block<3, 3>(kV, kGyroBias) = nav_.R * imu.dv_dgyro;
  F.block<3, 3>(kV, kAccelBias) = nav_.R * imu.dv_daccel;
  F.block<3, 2>(kV, kGravity) = T * B;
  return F;
}

void ImuFilter::propagateCovariance(const Covariance& F, const Covariance& Q) {
  P_ = (F * P_ * F.transpose() + Q).eval();
  symmetrise(P_);
  cross_ = (cross_ * F.transpose()).eval();
}

void ImuFilter::predict(const ImuPreintegration& imu, const ImuNoise& noise) {
  const ImuMotion m = imu.motion(bias_);
  const Covariance F = transition(imu);
  Covariance Q = Covariance::Zero();
  Matrix9d turn = Matrix9d::Identity();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = nav_.R;
  Q.topLeftCorner<9, 9>() = turn * imu.covariance * turn.transpose();
  Q.diagonal().segment<3>(kGyroBias).setConstant(noise.gyro_walk * noise.gyro_walk * m.duration_s);
  Q.diagonal().segment<3>(kAccelBias).setConstant(noise.accel_walk * noise.accel_walk * m.duration_s);
  propagateCovariance(F, Q);
  nav_ = nav_.after(m, gravity_);
  nav_.R = renormalised(nav_.R);
}

void ImuFilter::predictAtSpeed(const Vector6d& twist, double T) {
  constexpr double kAccel = 3.0, kTurn = 3.0;  // [m/s^2], [rad/s^2]: what a robot may do in between
  constexpr double kKnownS = 10;               // beyond, nothing is left to forget
  // Nor can the time be trusted to which the speed is applied: besides, a share of the step and a floor.
  const double sigma_m = 0.1 + 0.5 * T * twist.head<3>().norm(), sigma_rad = 0.05 + 0.5 * T * twist.tail<3>().norm();
  const double t = std::min(T, kKnownS);
  const Matrix3d R_before = nav_.R;
  const Vector3d v_before = nav_.v;
  const Pose T_base = retract(basePose(), T * twist), T_imu = T_base * T_base_imu_;
  nav_.R = renormalised(T_imu.linear());
  nav_.v = nav_.R * R_before.transpose() * v_before;
  nav_.p = T_imu.translation();
  Covariance F = Covariance::Identity(), Q = Covariance::Zero();
  F.block<3, 3>(kP, kV) = t * Matrix3d::Identity();
  const double a = kAccel * kAccel * t * t;
  Q.diagonal().segment<3>(kP).setConstant(0.25 * a * t * t + sigma_m * sigma_m);
  Q.block<3, 3>(kP, kV).diagonal().setConstant(0.5 * a * t);
  Q.block<3, 3>(kV, kP).diagonal().setConstant(0.5 * a * t);
  Q.diagonal().segment<3>(kV).setConstant(a);
  Q.diagonal().segment<3>(kTheta).setConstant(std::pow(std::min(kTurn * t * t, M_PI), 2) + sigma_rad * sigma_rad);
  propagateCovariance(F, Q);
}

void ImuFilter::correct(const Eigen::Matrix<double, kStates, 6>& gain_state, const Matrix6d& gain_clone,
                        const Matrix6d& W, const Vector6d& innovation) {
  const Vector error = gain_state * (W * innovation);
  P_ -= gain_state * W * gain_state.transpose();
  cross_ -= gain_clone * W * gain_state.transpose();
  symmetrise(P_);
  apply(error);
}

void ImuFilter::measureRest(const Vector3d& accel, double accel_sigma, const Vector3d& gyro, double gyro_sigma) {
  // force = R^T (a - g) + bias with a = 0; rate = bias.
  Jacobian6 H = Jacobian6::Zero();
  H.block<3, 3>(0, kTheta) = skew(nav_.R.transpose() * -gravity_);
  H.block<3, 3>(0, kAccelBias) = Matrix3d::Identity();
  H.block<3, 2>(0, kGravity) = -nav_.R.transpose() * gravityByAngles(gravity_);
  H.block<3, 3>(3, kGyroBias) = Matrix3d::Identity();
  Vector6d innovation, information;
  innovation << accel - (nav_.R.transpose() * -gravity_ + bias_.accel), gyro - bias_.gyro;
  information << Vector3d::Constant(1 / (accel_sigma * accel_sigma)), Vector3d::Constant(1 / (gyro_sigma * gyro_sigma));
  const Matrix6d S = H * P_ * H.transpose();
  correct(P_ * H.transpose(), cross_ * H.transpose(), weightOf(S, information.asDiagonal()), innovation);
}

void ImuFilter::measureStep(const Pose& T_previous_base, const Matrix6d& information) {
  const Jacobian6 J = baseJacobian();
  const Matrix6d A = adjoint(baseStep().inverse());
  // error of the step = error of now - A error of then
  const Eigen::Matrix<double, kStates, 6> gain_state = P_ * J.transpose() - cross_.transpose() * A.transpose();
  const Matrix6d gain_clone = cross_ * J.transpose() - clone_ * A.transpose();
  const Matrix6d W = weightOf(stepCovariance(), information);
  const Vector6d innovation = local(baseStep(), T_previous_base);
  if (innovation.dot(W * innovation) > 25.0) return;
  correct(gain_state, gain_clone, W, innovation);
}

Matrix6d ImuFilter::stepCovariance() const {
  const Jacobian6 J = baseJacobian();
  const Matrix6d A = adjoint(baseStep().inverse()), with_clone = A * cross_ * J.transpose();
  Matrix6d C = J * P_ * J.transpose() - with_clone - with_clone.transpose() + A * clone_ * A.transpose();
  symmetrise(C);
  return C;
}

Matrix6d ImuFilter::baseCovariance() const {
  const Jacobian6 J = baseJacobian();
  Matrix6d S = J * P_ * J.transpose();
  symmetrise(S);
  S.diagonal().array() += kFloor;
  return S;
}

Matrix6d ImuFilter::poseInformation() const {
  Matrix6d information = baseCovariance().inverse();
  symmetrise(information);
  return information;
}

void ImuFilter::measurePose(const Pose& T_odom_base, const Matrix6d& information) {
  const Jacobian6 J = baseJacobian();
  const Matrix6d S = baseCovariance();
  const Eigen::Matrix<double, kStates, 6> gain_state = P_ * J.transpose();
  // The mean follows the pose that was found, the covariance the information it was found with.
  const Vector6d found = S.ldlt().solve(local(basePose(), T_odom_base));
  const Matrix6d W = weightOf(S, information);
  correct(gain_state, cross_ * J.transpose(), W, Vector6d::Zero());
  apply(gain_state * found);
}

void ImuFilter::save(ByteWriter& state) const {
  for (const Eigen::Vector3d& v : {nav_.p, nav_.v, bias_.gyro, bias_.accel, gravity_}) state.put(v);
  state.put(nav_.R);
  state.put(T_base_imu_);
  state.put(P_);
  state.put(T_clone_);
  state.put(clone_);
  state.put(cross_);
}

void ImuFilter::load(ByteReader& state) {
  for (Eigen::Vector3d* v : {&nav_.p, &nav_.v, &bias_.gyro, &bias_.accel, &gravity_}) state.get(*v);
  state.get(nav_.R);
  state.get(T_base_imu_);
  state.get(P_);
  state.get(T_clone_);
  state.get(clone_);
  state.get(cross_);
}

}  // namespace scslam
