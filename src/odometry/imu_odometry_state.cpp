#include "scslam/odometry/imu_odometry.h"

namespace scslam {

void ImuOdometry::Params::describe(ParamVisitor& visitor) {
  visitor.group("map", map, "the local map and the match");
  visitor.group("noise", noise, "of the IMU");
  visitor.field("gravity_m_s2", gravity_m_s2, "length of gravity [m/s^2]", 0.1, 100.0);
  visitor.field("max_tilt_deg", max_tilt_deg,
                "tilt of the base at the start above which the IMU's axes are taken for swapped [deg]", 1.0, 180.0);
  visitor.field("max_imu_gap_s", max_imu_gap_s, "time without IMU readings that is bridged [s]", 0.001, 10.0);
  visitor.field("imu_time_offset_s", imu_time_offset_s,
                "added to the IMU's stamps [s]; > 0 where its clock is behind that of the scans", -10.0, 10.0);
  visitor.field("estimate_time_offset", estimate_time_offset, "correct the IMU's clock by comparing turns");
  visitor.field("use_recorded_odometry", use_recorded_odometry,
                "the recording's own odometry (wheels) is a measurement of each step");
  visitor.field("deskew", deskew, "compensate motion within a sweep");
}

void ImuOdometry::save(ByteWriter& state) const {
  map_.save(state);
  saveCloud(state, first_);
  stream_.save(state);
  estimator_->save(state);
  check_.save(state);
  state.put(inertial_);
  state.put(refused_);
  state.put(speed_known_);
  state.put(by_imu_);
  state.put(twist_);
  state.put(static_cast<std::int64_t>(stamp_.time_since_epoch().count()));
  state.put(T_recorded_.has_value());
  state.put(T_recorded_.value_or(Pose::Identity()));
  state.put(T_previous_);
  state.put(T_fitted_);
  for (const Eigen::Vector3d& v : {gyro_turn_, rate_begin_, rate_end_}) state.put(v);
  state.put(lost_);
  state.put(said_);
}

void ImuOdometry::load(ByteReader& state) {
  map_.load(state);
  loadCloud(state, first_);
  stream_.load(state);
  estimator_->load(state);
  check_.load(state);
  state.get(inertial_);
  state.get(refused_);
  state.get(speed_known_);
  state.get(by_imu_);
  state.get(twist_);
  stamp_ = Stamp(Stamp::duration(state.get<std::int64_t>()));
  const bool recorded = state.get<bool>();
  Pose T_recorded;
  state.get(T_recorded);
  T_recorded_ = recorded ? std::optional(T_recorded) : std::nullopt;
  state.get(T_previous_);
  state.get(T_fitted_);
  for (Eigen::Vector3d* v : {&gyro_turn_, &rate_begin_, &rate_end_}) state.get(*v);
  state.get(lost_);
  state.get(said_);
}

}  // namespace scslam
