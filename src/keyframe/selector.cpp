#include "scslam/keyframe/selector.h"

#include <cmath>

namespace scslam {

void KeyframeParams::describe(ParamVisitor& v) {
  v.field("distance_m", distance_m, "a keyframe every so many metres of displacement [m]", 0.01, 1000);
  v.field("rotation_deg", rotation_deg, "or after turning so far [deg]", 0.1, 360);
}

bool KeyframeSelector::isDue(const Pose& T_odom_base, const Matrix6d& step_covariance) {
  covariance_ = composeCovariance(covariance_, T_odom_base_.inverse() * T_odom_base, step_covariance);
  T_odom_base_ = T_odom_base;
  if (first_) return true;
  const Pose T_keyframe_base = T_odom_keyframe_.inverse() * T_odom_base;
  return T_keyframe_base.translation().norm() >= params_.distance_m ||
         rotationAngle(T_keyframe_base) >= params_.rotation_deg * M_PI / 180;
}

void KeyframeSelector::accept(Keyframe& keyframe) {
  if (!first_) travelled_m_ += (T_odom_keyframe_.inverse() * T_odom_base_).translation().norm();
  keyframe.T_odom_base = T_odom_base_;
  keyframe.travelled_m = travelled_m_;
  keyframe.step_covariance = first_ ? Matrix6d::Zero() : covariance_;
  T_odom_keyframe_ = T_odom_base_;
  covariance_.setZero();
  first_ = false;
}

void KeyframeSelector::save(ByteWriter& state) const {
  state.put(std::uint8_t{first_});
  state.put(T_odom_keyframe_);
  state.put(T_odom_base_);
  state.put(covariance_);
  state.put(travelled_m_);
}

void KeyframeSelector::load(ByteReader& state) {
  first_ = state.get<std::uint8_t>() != 0;
  state.get(T_odom_keyframe_);
  state.get(T_odom_base_);
  state.get(covariance_);
  state.get(travelled_m_);
}

}  // namespace scslam
