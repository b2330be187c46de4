// Planar odometry from wheel encoders: distance along the path and turns about the base's z axis, dead-reckoned in
// SE(2).
//
// Errors of wheels grow with the distance, not with time: a parked robot stays where it is.
#pragma once
#include "scslam/core/params.h"
#include "sim/navigation_sensor.h"

namespace scslam::sim {

struct WheelOdometryModel : ParamSetOf<WheelOdometryModel> {
  bool enabled = true;
  double rate_hz = 20;
  double scale_error = 0.005;         ///< share: wheels believed larger than they are
  double yaw_scale_error = 0.01;      ///< share: track believed narrower than it is
  double yaw_bias_deg_per_m = 0.01;   ///< wheels of unequal size
  double slip_m_per_sqrt_m = 0.01;    ///< sigma of the distance after 1 m
  double slip_deg_per_sqrt_m = 0.05;  ///< sigma of the heading after 1 m
  double tick_m = 0.001;              ///< path of a wheel per encoder tick; 0: no quantisation
  double track_m = 1.6;               ///< between left and right wheel

  void describe(ParamVisitor& v) override;
  /// The same wheels without any error.
  WheelOdometryModel perfect() const;
};

/// Emits mrpt::obs::CObservationOdometry, label "wheels": T_odom_base, which is the identity at time 0 (odometry), the
/// mean velocity since the sample before, and the ticks of both wheels when tick_m > 0.
class WheelOdometry : public NavigationSensor {
 public:
  WheelOdometry(const WheelOdometryModel& model, const Trajectory& trajectory, std::uint64_t seed, Stamp start);

 private:
  mrpt::obs::CObservation::Ptr measure(std::uint32_t index, double t) override;

  WheelOdometryModel model_;
  CounterRandom random_;
  double left_m_ = 0, right_m_ = 0;  ///< what the wheels rolled
  std::int64_t left_ticks_ = 0, right_ticks_ = 0;
  double x_ = 0, y_ = 0, yaw_ = 0;  ///< T_odom_base
};

}  // namespace scslam::sim
