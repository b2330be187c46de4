// What IMU, wheel odometry and GNSS share: a sample clock, stamps, where they sit on the robot.
#pragma once
#include <mrpt/obs/CObservation.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "scslam/core/counter_random.h"
#include "scslam/core/stamp.h"
#include "sim/trajectory.h"

namespace scslam::sim {

/// Takes each observation as it is made.
using ObservationSink = std::function<void(const mrpt::obs::CObservation::Ptr&)>;

/// A sensor that samples at a fixed rate: sample k at k / rate_hz seconds after the start, from 0 to the end of the
/// drive. A simulator's loop calls upTo() with growing times; what comes out does not depend on how often it does.
class NavigationSensor {
 public:
  /// @param start the stamp of time 0. The trajectory must outlive the sensor.
  NavigationSensor(const Trajectory& trajectory, double rate_hz, bool enabled, Stamp start)
      : trajectory_(trajectory), rate_hz_(rate_hz), enabled_(enabled), start_(start) {}
  virtual ~NavigationSensor() = default;
  NavigationSensor(const NavigationSensor&) = delete;
  NavigationSensor& operator=(const NavigationSensor&) = delete;

  /// When the next sample is due [s]; infinite once the drive is over or when the sensor is off.
  double nextTime() const {
    const double t = static_cast<double>(index_) / rate_hz_;
    return enabled_ && t <= trajectory_.duration() + kLate ? t : std::numeric_limits<double>::infinity();
  }
  /// Emits the samples due at or before t [s] that were not emitted yet, in time order.
  void upTo(double t, const ObservationSink& sink);

 protected:
  /// Sample number `index` at t [s]; called once for each index in turn.
  /// @return null when the sensor has nothing to say. The stamp is set by the caller.
  virtual mrpt::obs::CObservation::Ptr measure(std::uint32_t index, double t) = 0;
  const Trajectory& trajectory() const { return trajectory_; }
  double period() const { return 1 / rate_hz_; }
  Stamp stampAt(double t) const;

 private:
  static constexpr double kLate = 1e-9;  ///< [s], what the rounding of a duration may lose
  const Trajectory& trajectory_;
  double rate_hz_;
  bool enabled_;
  Stamp start_;
  std::uint32_t index_ = 0;
};

/// T_base_sensor from a position [m] and roll, pitch, yaw [deg] (R = Rz Ry Rx), three numbers each.
/// @throw usageError "SENSOR: translation_m …"
Pose mounting(const std::vector<double>& translation_m, const std::vector<double>& rpy_deg, const std::string& sensor);

/// Three numbers of a parameter list. @throw usageError "SENSOR: KEY needs three finite numbers".
Eigen::Vector3d threeOf(const std::vector<double>& list, const std::string& sensor, const char* key);

/// Three standard normals from one block.
inline Eigen::Vector3d normals(const std::array<std::uint32_t, 4>& block) {
  return Eigen::Vector3f(normalOf(block[0]), normalOf(block[1]), normalOf(block[2])).cast<double>();
}

}  // namespace scslam::sim
