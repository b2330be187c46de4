#include "scslam/odometry/imu_smoother.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

namespace scslam {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

namespace {

constexpr int kNode = ImuNode::kSize;
constexpr int kIterations = 4;
constexpr double kShortest = 1e-3, kLongest = 10;  // [s]: what a step counts as at least and, without IMU, at most
constexpr double kHuber2 = 16.0;  // r' L r above which a scan's pose is taken for wrong: about 98 % of right ones

Eigen::Index offsetOf(std::size_t node) { return 2 + kNode * static_cast<Eigen::Index>(node); }

/// Weight of a residual of squared length r2.
double huber(double r2) { return r2 <= kHuber2 ? 1.0 : std::sqrt(kHuber2 / r2); }

/// Adds J' W J and J' W r, J = [by_gravity, by_i at node i, by_j at node j].
template <int kRows>
void addResidual(const ImuResidual<kRows>& res, const Eigen::Matrix<double, kRows, kRows>& W, std::size_t i,
                 std::size_t j, MatrixXd& system) {
  Eigen::Matrix<double, kRows, 2 + 2 * kNode> J;
  J << res.by_gravity, res.by_i, res.by_j;
  const Eigen::Matrix<double, 2 + 2 * kNode, kRows> JtW = J.transpose() * W;
  const Eigen::Matrix<double, 2 + 2 * kNode, 2 + 2 * kNode> H = JtW * J;
  const Eigen::Matrix<double, 2 + 2 * kNode, 1> g = JtW * res.r;
  const Eigen::Index from[3] = {0, 2, 2 + kNode}, to[3] = {0, offsetOf(i), offsetOf(j)}, size[3] = {2, kNode, kNode};
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b)
      system.block(to[a], to[b], size[a], size[b]) += H.block(from[a], from[b], size[a], size[b]);
    system.col(system.cols() - 1).segment(to[a], size[a]) += g.segment(from[a], size[a]);
  }
}

/// A step that was measured or guessed. Squared weight: wheels that are blocked lose their say altogether.
void addStep(const Pose& T_i_j, const Matrix6d& information, const ImuNode& i, const ImuNode& j, std::size_t k,
             MatrixXd& system) {
  const ImuResidual<6> step = stepResidual(i, j, T_i_j);
  const double weight = huber(step.r.dot(information * step.r));
  addResidual<6>(step, weight * weight * information, k - 1, k, system);
}

/// H^-1 of a system whose directions all have a prior; what is left open by rounding is held by a little weight.
Eigen::LDLT<MatrixXd> decomposed(MatrixXd H) {
  H.diagonal().array() += 1e-9;
  return Eigen::LDLT<MatrixXd>(H);
}

}  // namespace

Matrix6d ImuSmoother::toImu(const Matrix6d& information_base) const {
  const Matrix6d A = adjoint(T_base_imu_);  // error of the base = A error of the IMU
  return A.transpose() * information_base * A;
}

void ImuSmoother::begin(const Pose& T_odom_base, const Pose& T_base_imu, const Vector3d& gravity,
                        const Vector3d& velocity, const Start& start) {
  constexpr double kExact = 1e-4;  // [m, rad]
  T_base_imu_ = T_base_imu;
  gravity_ = gravity;
  const Pose T_odom_imu = T_odom_base * T_base_imu;
  Entry first;
  first.node.nav = {T_odom_imu.linear(), T_odom_imu.translation(), velocity};
  window_.assign(1, first);
  Eigen::Matrix<double, kPrior, 1> sigma;
  sigma << Eigen::Vector2d::Constant(start.gravity_rad), Vector6d::Constant(kExact),
      Vector3d::Constant(start.velocity_mps), Vector3d::Constant(start.gyro_bias), Vector3d::Constant(start.accel_bias);
  prior_H_ = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  prior_g_.setZero();
  prior_node_ = first.node;
  prior_gravity_ = gravity;
}

void ImuSmoother::beginStep() {
  while (window_.size() >= static_cast<std::size_t>(std::max(lag_, 2))) marginaliseOldest();
}

// ---- motion ----

void ImuSmoother::integrate(const std::vector<ImuReading>& readings, const ImuBias& bias, Entry& entry) {
  entry.imu.emplace(readings, bias, entry.noise);
  entry.duration_s = entry.imu->motion().duration_s;
  Matrix9d C = entry.imu->covariance;
  C.diagonal().array() += 1e-10;
  entry.imu_information = C.llt().solve(Matrix9d::Identity());
}

void ImuSmoother::predict(const ImuPreintegration& imu, const ImuNoise& noise) {
  Entry entry;
  entry.noise = noise;
  integrate(imu.readings(), newest().bias, entry);
  entry.node.bias = newest().bias;
  entry.node.nav = newest().nav.after(entry.imu->motion(), gravity_);
  window_.push_back(std::move(entry));
}

void ImuSmoother::predictAtSpeed(const Vector6d& twist, double duration_s) {
  constexpr double kAccel = 3.0, kTurn = 3.0;  // [m/s^2], [rad/s^2]: what a robot may do in between
  const double T = std::clamp(duration_s, kShortest, kLongest);
  const Vector6d way = duration_s * twist;
  const double sigma_m = 0.1 + 0.5 * way.head<3>().norm() + 0.5 * kAccel * T * T;
  const double sigma_rad = std::min(0.05 + 0.5 * way.tail<3>().norm() + kTurn * T * T, M_PI);
  Vector6d information;
  information << Vector3d::Constant(1 / (sigma_m * sigma_m)), Vector3d::Constant(1 / (sigma_rad * sigma_rad));
  Entry entry;
  entry.duration_s = T;
  entry.guess =
      Measured{T_base_imu_.inverse() * retract(Pose::Identity(), way) * T_base_imu_, toImu(information.asDiagonal())};
  const Pose T_odom_imu = newest().pose() * entry.guess->T;
  entry.node.bias = newest().bias;
  entry.node.nav = {T_odom_imu.linear(), T_odom_imu.translation(),
                    T_odom_imu.linear() * newest().nav.R.transpose() * newest().nav.v};
  window_.push_back(std::move(entry));
}

// ---- measurements ----

void ImuSmoother::measureRest(const Vector3d& accel, double accel_sigma, const Vector3d& gyro, double gyro_sigma) {
  const NavState& nav = prior_node_.nav;
  Eigen::Matrix<double, 6, kPrior> J = Eigen::Matrix<double, 6, kPrior>::Zero();
  J.block<3, 2>(0, 0) = -nav.R.transpose() * gravityByAngles(prior_gravity_);
  J.block<3, 3>(0, 2 + ImuNode::kTheta) = skew(nav.R.transpose() * -prior_gravity_);
  J.block<3, 3>(0, 2 + ImuNode::kAccelBias).setIdentity();
  J.block<3, 3>(3, 2 + ImuNode::kGyroBias).setIdentity();
  Vector6d r, information;
  r << nav.R.transpose() * -prior_gravity_ + prior_node_.bias.accel - accel, prior_node_.bias.gyro - gyro;
  information << Vector3d::Constant(1 / (accel_sigma * accel_sigma)), Vector3d::Constant(1 / (gyro_sigma * gyro_sigma));
  prior_H_ += J.transpose() * information.asDiagonal() * J;
  prior_g_ += J.transpose() * information.asDiagonal() * r;
  optimise();
}

void ImuSmoother::measureStep(const Pose& T_previous_base, const Matrix6d& information) {
  window_.back().step = Measured{T_base_imu_.inverse() * T_previous_base * T_base_imu_, toImu(information)};
  optimise();
}

void ImuSmoother::measurePose(const Pose& T_odom_base, const Matrix6d& information) {
  window_.back().pose = Measured{T_odom_base * T_base_imu_, toImu(information)};
  optimise();
}

// ---- the window ----

void ImuSmoother::addPrior(System& system) const {
  const ImuNode& node = window_.front().node;
  Eigen::Matrix<double, kPrior, 1> e;
  e << acrossGravity(prior_gravity_).transpose() * prior_gravity_.cross(gravity_) / gravity_.squaredNorm(),
      node.nav.p - prior_node_.nav.p, so3Log(prior_node_.nav.R.transpose() * node.nav.R),
      node.nav.v - prior_node_.nav.v, node.bias.gyro - prior_node_.bias.gyro, node.bias.accel - prior_node_.bias.accel;
  system.topLeftCorner<kPrior, kPrior>() += prior_H_;
  system.col(system.cols() - 1).head<kPrior>() += prior_H_ * e + prior_g_;
}

void ImuSmoother::addLink(std::size_t k, System& system) const {
  const Entry& entry = window_[k];
  const ImuNode &i = window_[k - 1].node, &j = entry.node;
  if (entry.imu)
    addResidual(imuResidual(i, j, gravity_, *entry.imu), entry.imu_information, k - 1, k, system);
  else
    addGuess(k, system);
  const double T = std::max(entry.duration_s, kShortest);
  const auto information = [T](double walk) { return Vector3d::Constant(1 / (walk * walk * T + 1e-14)); };
  Vector6d walk;
  walk << information(entry.noise.gyro_walk), information(entry.noise.accel_walk);
  addResidual<6>(biasResidual(i, j), walk.asDiagonal(), k - 1, k, system);
  if (entry.step) addStep(entry.step->T, entry.step->information, i, j, k, system);
}

void ImuSmoother::addGuess(std::size_t k, System& system) const {
  constexpr double kAccel = 3.0, kJitter = 0.1;  // [m/s^2], [m]: how far the mean velocity is from the one at the end
  const Entry& entry = window_[k];
  const ImuNode &i = window_[k - 1].node, &j = entry.node;
  addStep(entry.guess->T, entry.guess->information, i, j, k, system);
  const double sigma = kAccel * entry.duration_s + kJitter / entry.duration_s;
  addResidual<3>(speedResidual(i, j, entry.duration_s), Matrix3d::Identity() / (sigma * sigma), k - 1, k, system);
}

ImuSmoother::System ImuSmoother::linearised(std::size_t count) const {
  const Eigen::Index n = offsetOf(count);
  System system = System::Zero(n, n + 1);
  addPrior(system);
  for (std::size_t k = 0; k < count; ++k) {
    if (k > 0) addLink(k, system);
    if (!window_[k].pose) continue;
    const ImuResidual<6> pose = poseResidual(window_[k].node, window_[k].pose->T);
    // Against the IMU a match may be wrong; against a guess it is right.
    const double weight = window_[k].imu ? huber(pose.r.dot(window_[k].pose->information * pose.r)) : 1.0;
    // by_i is zero: any other node may stand for it.
    addResidual<6>(pose, weight * window_[k].pose->information, k > 0 ? k - 1 : k, k, system);
  }
  return system;
}

void ImuSmoother::optimise() {
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const System system = linearised(window_.size());
    const Eigen::Index n = system.rows();
    const Eigen::VectorXd step = -decomposed(system.leftCols(n)).solve(system.col(n));
    if (!step.allFinite()) return;
    gravity_ = turnedGravity(gravity_, step.head<2>());
    for (std::size_t k = 0; k < window_.size(); ++k) window_[k].node.apply(step.segment<kNode>(offsetOf(k)));
    if (step.cwiseAbs().maxCoeff() < 1e-6) return;
  }
}

void ImuSmoother::marginaliseOldest() {
  // Over (gravity, oldest, next): the pose of `next` stays in the window, only what touches the oldest is summed up.
  const std::optional<Measured> pose_of_next = std::exchange(window_[1].pose, std::nullopt);
  const System system = linearised(2);
  window_[1].pose = pose_of_next;
  const Eigen::Index n = system.rows();
  MatrixXd keep_H(kPrior, kPrior), keep_drop(kPrior, kNode);
  Eigen::VectorXd keep_g(kPrior);
  const auto kept = [](Eigen::Index k) { return k < 2 ? k : k + kNode; };
  for (Eigen::Index a = 0; a < kPrior; ++a) {
    for (Eigen::Index b = 0; b < kPrior; ++b) keep_H(a, b) = system(kept(a), kept(b));
    keep_drop.row(a) = system.row(kept(a)).segment(2, kNode);
    keep_g(a) = system(kept(a), n);
  }
  const auto drop = decomposed(system.block(2, 2, kNode, kNode));
  const Eigen::VectorXd drop_g = system.col(n).segment(2, kNode);
  const MatrixXd H = keep_H - keep_drop * drop.solve(keep_drop.transpose());
  prior_H_ = 0.5 * (H + H.transpose());
  prior_g_ = keep_g - keep_drop * drop.solve(drop_g);
  window_.pop_front();
  window_.front().imu.reset();
  window_.front().guess.reset();
  window_.front().step.reset();
  prior_node_ = window_.front().node;
  prior_gravity_ = gravity_;
}

Matrix6d ImuSmoother::stepCovariance() const {
  if (window_.size() < 2) return Matrix6d::Zero();
  const System system = linearised(window_.size());
  const Eigen::Index n = system.rows(), last = 2 * kNode;
  MatrixXd select = MatrixXd::Zero(n, last);
  select.bottomRows(last).setIdentity();
  const MatrixXd C = decomposed(system.leftCols(n)).solve(select).bottomRows(last);  // of the last two nodes
  const ImuNode &i = window_[window_.size() - 2].node, &j = newest();
  const ImuResidual<6> step = stepResidual(i, j, i.pose().inverse() * j.pose());
  Eigen::Matrix<double, 6, 2 * kNode> J;
  J << step.by_i, step.by_j;
  J = (adjoint(T_base_imu_) * J).eval();
  const Matrix6d covariance = J * C * J.transpose();
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace scslam
