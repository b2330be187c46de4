#include "sim/wheel_odometry.h"

#include <mrpt/obs/CObservationOdometry.h>

#include <cmath>

namespace scslam::sim {

namespace {

/// Path [m], negative when reversing, and turn about the base's z axis [rad].
struct Rolled {
  double path = 0, turn = 0;
};

/// Between t0 and t1, by Simpson's rule on four intervals: far below a tick for any sample rate.
Rolled rolledBetween(const Trajectory& trajectory, double t0, double t1) {
  constexpr int kIntervals = 4;
  Rolled sum;
  for (int i = 0; i <= kIntervals; ++i) {
    const MotionState s = trajectory.state(t0 + (t1 - t0) * i / kIntervals);
    const double weight = i == 0 || i == kIntervals ? 1 : i % 2 == 1 ? 4 : 2;
    const double forward = s.velocity.dot(s.T_world_base.linear().col(0));
    sum.path += weight * std::copysign(s.velocity.norm(), forward);
    sum.turn += weight * s.angular_velocity.z();
  }
  const double h = (t1 - t0) / (3 * kIntervals);
  return {sum.path * h, sum.turn * h};
}

}  // namespace

void WheelOdometryModel::describe(ParamVisitor& v) {
  v.field("enabled", enabled, "is there wheel odometry?");
  v.field("rate_hz", rate_hz, "samples per second", 0.1, 10000);
  v.field("scale_error", scale_error, "distances are too long by this share", -0.5, 0.5);
  v.field("yaw_scale_error", yaw_scale_error, "turns are too large by this share", -0.5, 0.5);
  v.field("yaw_bias_deg_per_m", yaw_bias_deg_per_m, "false turn from unequal wheels [deg/m]", -10, 10);
  v.field("slip_m_per_sqrt_m", slip_m_per_sqrt_m, "sigma of the distance after 1 m, growing with its root [m]", 0, 1);
  v.field("slip_deg_per_sqrt_m", slip_deg_per_sqrt_m, "sigma of the heading after 1 m, growing with its root [deg]", 0,
          45);
  v.field("tick_m", tick_m, "path of a wheel per encoder tick [m]; 0: exact", 0, 1);
  v.field("track_m", track_m, "distance between left and right wheels [m]", 0.05, 10);
}

WheelOdometryModel WheelOdometryModel::perfect() const {
  WheelOdometryModel model = *this;
  model.scale_error = model.yaw_scale_error = model.yaw_bias_deg_per_m = 0;
  model.slip_m_per_sqrt_m = model.slip_deg_per_sqrt_m = model.tick_m = 0;
  return model;
}

WheelOdometry::WheelOdometry(const WheelOdometryModel& model, const Trajectory& trajectory, std::uint64_t seed,
                             Stamp start)
    : NavigationSensor(trajectory, model.rate_hz, model.enabled, start),
      model_(model),
      random_(seed, RandomStream::kWheel) {}

mrpt::obs::CObservation::Ptr WheelOdometry::measure(std::uint32_t index, double t) {
  const double t_before = index == 0 ? t : static_cast<double>(index - 1) * period();
  const Rolled truth = rolledBetween(trajectory(), t_before, t);
  const double travelled = std::abs(truth.path), root = std::sqrt(travelled);
  const Eigen::Vector3d n = normals(random_.block(index));
  constexpr double kDeg = M_PI / 180;
  double path = truth.path * (1 + model_.scale_error) + model_.slip_m_per_sqrt_m * root * n.x();
  double turn = truth.turn * (1 + model_.yaw_scale_error) + model_.yaw_bias_deg_per_m * kDeg * truth.path +
                model_.slip_deg_per_sqrt_m * kDeg * root * n.y();

  if (model_.tick_m > 0) {
    // Totals are quantised, so that what is lost in one sample is found in the next.
    left_m_ += path - turn * model_.track_m / 2;
    right_m_ += path + turn * model_.track_m / 2;
    const std::int64_t left = std::llround(left_m_ / model_.tick_m), right = std::llround(right_m_ / model_.tick_m);
    const double d_left = static_cast<double>(left - left_ticks_) * model_.tick_m;
    const double d_right = static_cast<double>(right - right_ticks_) * model_.tick_m;
    left_ticks_ = left, right_ticks_ = right;
    path = (d_left + d_right) / 2;
    turn = (d_right - d_left) / model_.track_m;
  }
  // The chord of a circular arc.
  const double half = turn / 2, chord = std::abs(half) < 1e-6 ? path : path * std::sin(half) / half;
  x_ += chord * std::cos(yaw_ + half);
  y_ += chord * std::sin(yaw_ + half);
  yaw_ = std::remainder(yaw_ + turn, 2 * M_PI);

  auto observation = mrpt::obs::CObservationOdometry::Create();
  observation->sensorLabel = "wheels";
  observation->odometry = mrpt::poses::CPose2D(x_, y_, yaw_);
  observation->hasVelocities = true;
  observation->velocityLocal = mrpt::math::TTwist2D(path / period(), 0, turn / period());
  observation->hasEncodersInfo = model_.tick_m > 0;
  observation->encoderLeftTicks = static_cast<std::int32_t>(left_ticks_);
  observation->encoderRightTicks = static_cast<std::int32_t>(right_ticks_);
  return observation;
}

}  // namespace scslam::sim
