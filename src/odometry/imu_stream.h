// The inertial readings that came with the scans, as a front-end uses them: over an interval of time.
#pragma once
#include <deque>
#include <vector>

#include "scslam/core/bytes.h"
#include "scslam/odometry/imu_preintegration.h"
#include "scslam/sensor/navigation.h"

namespace scslam {

class ImuStream {
 public:
  /// @param max_gap_s longest time without a sample that is bridged (by a straight line; by the last sample at an end).
  explicit ImuStream(double max_gap_s) : max_gap_s_(max_gap_s) {}

  /// Samples not later than the newest, or not finite, are dropped.
  void add(const std::vector<ImuSample>& samples);
  bool empty() const { return samples_.empty(); }
  const std::deque<ImuSample>& samples() const { return samples_; }

  /// What the sensor's accelerations are multiplied with (9.8 where they come in g).
  double accel_scale = 1;
  /// Added to the stamps of the samples: > 0 where the sensor's clock is behind that of the scans.
  double time_offset_s = 0;

  /// Readings at `from`, at every sample in between, and at `to`, with t seconds after `from`.
  /// @return empty when from >= to or a longer time than max_gap_s is without samples.
  std::vector<ImuReading> between(Stamp from, Stamp to) const;
  /// Keeps what is needed from `stamp` on.
  void forgetBefore(Stamp stamp);

  void save(ByteWriter& state) const;
  void load(ByteReader& state);

 private:
  ImuReading reading(const ImuSample& sample, Stamp zero) const;
  double max_gap_s_;
  std::deque<ImuSample> samples_;
};

}  // namespace scslam
