#include "scslam/odometry/imu_smoother.h"

namespace scslam {
namespace {

void put(ByteWriter& state, const ImuBias& bias) {
  state.put(bias.gyro);
  state.put(bias.accel);
}
void get(ByteReader& state, ImuBias& bias) {
  state.get(bias.gyro);
  state.get(bias.accel);
}

void put(ByteWriter& state, const ImuNode& node) {
  state.put(node.nav.R);
  state.put(node.nav.p);
  state.put(node.nav.v);
  put(state, node.bias);
}
void get(ByteReader& state, ImuNode& node) {
  state.get(node.nav.R);
  state.get(node.nav.p);
  state.get(node.nav.v);
  get(state, node.bias);
}

template <class Measured>
void put(ByteWriter& state, const std::optional<Measured>& measured) {
  const Measured value = measured.value_or(Measured{});
  state.put(measured.has_value());
  state.put(value.T);
  state.put(value.information);
}
template <class Measured>
void get(ByteReader& state, std::optional<Measured>& measured) {
  const bool has = state.get<bool>();
  Measured value;
  state.get(value.T);
  state.get(value.information);
  measured = has ? std::optional(value) : std::nullopt;
}

}  // namespace

void ImuSmoother::save(ByteWriter& state) const {
  state.put(T_base_imu_);
  state.put(gravity_);
  state.put(prior_H_);
  state.put(prior_g_);
  put(state, prior_node_);
  state.put(prior_gravity_);
  state.put(std::uint64_t{window_.size()});
  for (const Entry& entry : window_) {
    put(state, entry.node);
    state.put(entry.duration_s);
    put(state, entry.guess);
    put(state, entry.step);
    put(state, entry.pose);
    state.put(entry.imu.has_value());
    if (!entry.imu) continue;
    put(state, entry.imu->bias());
    for (const double noise : {entry.noise.gyro, entry.noise.accel, entry.noise.gyro_walk, entry.noise.accel_walk})
      state.put(noise);
    state.put(std::uint64_t{entry.imu->readings().size()});
    for (const ImuReading& reading : entry.imu->readings()) {
      state.put(reading.t);
      state.put(reading.gyro);
      state.put(reading.accel);
    }
  }
}

void ImuSmoother::load(ByteReader& state) {
  state.get(T_base_imu_);
  state.get(gravity_);
  state.get(prior_H_);
  state.get(prior_g_);
  get(state, prior_node_);
  state.get(prior_gravity_);
  window_.clear();
  for (auto left = state.get<std::uint64_t>(); left > 0; --left) {
    Entry entry;
    get(state, entry.node);
    state.get(entry.duration_s);
    get(state, entry.guess);
    get(state, entry.step);
    get(state, entry.pose);
    if (state.get<bool>()) {
      ImuBias bias;
      get(state, bias);
      for (double* noise : {&entry.noise.gyro, &entry.noise.accel, &entry.noise.gyro_walk, &entry.noise.accel_walk})
        state.get(*noise);
      std::vector<ImuReading> readings;
      for (auto count = state.get<std::uint64_t>(); count > 0; --count) {
        ImuReading& reading = readings.emplace_back();
        state.get(reading.t);
        state.get(reading.gyro);
        state.get(reading.accel);
      }
      integrate(readings, bias, entry);
    }
    window_.push_back(std::move(entry));
  }
  if (window_.empty()) throw inputError("a saved smoother has no nodes");
}

}  // namespace scslam
