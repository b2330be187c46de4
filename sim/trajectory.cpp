#include "sim/trajectory.h"

#include <algorithm>
#include <cmath>

#include "scslam/core/error.h"

namespace scslam::sim {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Cumulative cubic B-spline weights b1, b2, b3 (b0 = 1) and their derivatives with respect to u.
struct Weights {
  std::array<double, 3> b, d, dd;
  explicit Weights(double u)
      : b{(5 + 3 * u - 3 * u * u + u * u * u) / 6, (1 + 3 * u + 3 * u * u - 2 * u * u * u) / 6, u * u * u / 6},
        d{(1 - u) * (1 - u) / 2, (1 + 2 * u - 2 * u * u) / 2, u * u / 2},
        dd{u - 1, 1 - 2 * u, u} {}
};

}  // namespace

Trajectory::Trajectory(std::vector<Pose> control, double knot_s) : control_(std::move(control)), knot_s_(knot_s) {
  if (control_.size() < 4 || !(knot_s > 0))
    throw Error(ExitCode::kUsage, "a trajectory needs at least four control poses and a positive knot interval");
  for (std::size_t i = 0; i + 1 < control_.size(); ++i)
    turn_.push_back(so3Log(control_[i].linear().transpose() * control_[i + 1].linear()));
}

double Trajectory::duration() const { return knot_s_ * static_cast<double>(control_.size() - 3); }

Trajectory::Segment Trajectory::segment(double t) const {
  const double x = std::clamp(t, 0.0, duration()) / knot_s_;
  const auto first = std::min(static_cast<std::size_t>(x), control_.size() - 4);
  return {first, x - static_cast<double>(first)};
}

Pose Trajectory::pose(double t) const {
  const auto [i, u] = segment(t);
  const Weights w(u);
  Pose T = control_[i];
  for (std::size_t k = 0; k < 3; ++k) {
    T.translation() += w.b[k] * (control_[i + k + 1].translation() - control_[i + k].translation());
    T.linear() = T.linear() * so3Exp(w.b[k] * turn_[i + k]);
  }
  return T;
}

MotionState Trajectory::state(double t) const {
  const auto [i, u] = segment(t);
  const Weights w(u);
  MotionState s;
  Pose& T = s.T_world_base;
  T = control_[i];
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3d step = control_[i + k + 1].translation() - control_[i + k].translation();
    T.translation() += w.b[k] * step;
    s.velocity += w.d[k] / knot_s_ * step;
    s.acceleration += w.dd[k] / (knot_s_ * knot_s_) * step;
    // Angular rates are carried into the frame after this factor, then this factor's own is added.
    const Vector3d& turn = turn_[i + k];
    const Matrix3d A = so3Exp(w.b[k] * turn);
    const Vector3d carried = A.transpose() * s.angular_velocity, own = w.d[k] / knot_s_ * turn;
    s.angular_acceleration =
        A.transpose() * s.angular_acceleration + carried.cross(own) + w.dd[k] / (knot_s_ * knot_s_) * turn;
    s.angular_velocity = carried + own;
    T.linear() = T.linear() * A;
  }
  return s;
}

double Trajectory::length() const {
  double length = 0;
  Vector3d last = pose(0).translation();
  for (double t = knot_s_; t <= duration() + 1e-9; t += knot_s_) {
    const Vector3d now = pose(t).translation();
    length += (now - last).norm();
    last = now;
  }
  return length;
}

}  // namespace scslam::sim
