#include "scslam/odometry/imu_stream.h"

#include <algorithm>

namespace scslam {
namespace {

ImuReading interpolated(const ImuReading& a, const ImuReading& b, double t) {
  const double u = b.t > a.t ? (t - a.t) / (b.t - a.t) : 0.0;
  return {t, (1 - u) * a.gyro + u * b.gyro, (1 - u) * a.accel + u * b.accel};
}

}  // namespace

void ImuStream::add(const std::vector<ImuSample>& samples) {
  for (const ImuSample& sample : samples) {
    if (!sample.gyro_rad_s.allFinite() || !sample.accel_m_s2.allFinite()) continue;
    if (samples_.empty() || sample.stamp > samples_.back().stamp) samples_.push_back(sample);
  }
}

ImuReading ImuStream::reading(const ImuSample& sample, Stamp zero) const {
  return {secondsBetween(zero, sample.stamp) + time_offset_s, sample.gyro_rad_s, accel_scale * sample.accel_m_s2};
}

std::vector<ImuReading> ImuStream::between(Stamp from, Stamp to) const {
  const double end = secondsBetween(from, to);
  if (samples_.empty() || end <= 0) return {};
  const auto later = [&](double t, const ImuSample& sample) { return t < reading(sample, from).t; };
  auto next = std::upper_bound(samples_.begin(), samples_.end(), 0.0, later);
  std::vector<ImuReading> result;
  ImuReading before = reading(next == samples_.begin() ? *next : *std::prev(next), from);
  if (next == samples_.begin()) {  // the first sample holds for the time before it
    if (before.t > max_gap_s_) return {};
    before.t = 0;
  }
  result.push_back(before);
  for (; next != samples_.end(); ++next) {
    const ImuReading after = reading(*next, from);
    if (after.t - result.back().t > max_gap_s_) return {};
    if (result.size() == 1) result.front() = interpolated(before, after, 0.0);
    if (after.t >= end) {
      result.push_back(interpolated(result.back(), after, end));
      return result;
    }
    result.push_back(after);
  }
  if (end - result.back().t > max_gap_s_) return {};
  if (result.size() == 1) result.front().t = 0;
  ImuReading last = result.back();
  last.t = end;
  result.push_back(last);
  return result;
}

void ImuStream::forgetBefore(Stamp stamp) {
  while (samples_.size() > 1 && reading(samples_[1], stamp).t <= 0) samples_.pop_front();
}

void ImuStream::save(ByteWriter& state) const {
  state.put(accel_scale);
  state.put(time_offset_s);
  state.put(std::uint64_t{samples_.size()});
  for (const ImuSample& sample : samples_) {
    state.put(static_cast<std::int64_t>(sample.stamp.time_since_epoch().count()));
    state.put(sample.gyro_rad_s);
    state.put(sample.accel_m_s2);
  }
}

void ImuStream::load(ByteReader& state) {
  state.get(accel_scale);
  state.get(time_offset_s);
  samples_.clear();
  for (auto left = state.get<std::uint64_t>(); left > 0; --left) {
    ImuSample sample;
    sample.stamp = Stamp(Stamp::duration(state.get<std::int64_t>()));
    state.get(sample.gyro_rad_s);
    state.get(sample.accel_m_s2);
    samples_.push_back(sample);
  }
}

}  // namespace scslam
