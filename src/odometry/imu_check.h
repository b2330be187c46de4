// Is this inertial sensor what it should be? Units, axes, clock: each fault that users meet, in one clear line.
#pragma once
#include <deque>
#include <string>

#include "scslam/core/bytes.h"
#include "scslam/odometry/imu_preintegration.h"
#include "scslam/sensor/navigation.h"

namespace scslam {

/// What the first readings say.
struct ImuStart {
  bool enough = false;                              ///< readings to judge by
  bool usable = false;                              ///< makes sense as m/s^2 and rad/s (after accel_scale)
  bool still = false;                               ///< neither turning nor accelerating
  double accel_scale = 1;                           ///< to m/s^2
  Eigen::Vector3d accel = Eigen::Vector3d::Zero();  ///< mean specific force, scaled [m/s^2], frame imu
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();   ///< mean rate [rad/s], frame imu
  std::string note;                                 ///< what is unusual, and what to do about it; empty: nothing
};

/// @param samples of the first tenths of a second.
/// @param max_tilt_deg by which the base may be tilted at the start; more is taken for swapped axes.
ImuStart startOf(const std::deque<ImuSample>& samples, const Pose& T_base_imu, double gravity_m_s2,
                 double max_tilt_deg);

/// Compares turns by the gyroscope with turns by the scans.
///
/// Where the IMU's clock is behind by tau, its turn over an interval has tau (w_end - w_begin) too much: the regression
/// of the disagreements over the changes of the rate is the offset, and what it leaves is noise.
class ImuCheck {
 public:
  /// One step between scans. @param by_gyro, by_scan rotation vectors [rad]; rates at both ends [rad/s], all in one
  /// frame (base).
  void add(const Eigen::Vector3d& by_gyro, const Eigen::Vector3d& by_scan, const Eigen::Vector3d& rate_begin,
           const Eigen::Vector3d& rate_end);

  struct Offset {
    double seconds = 0;  ///< to add to the stamps of the IMU
    double sigma_s = 1;
  };
  Offset offset() const;
  /// Forgets what it knows of the clock (it was corrected).
  void restartOffset();
  /// A line when turns by the gyroscope are not those by the scans; empty: they are, or there were too few.
  std::string disagreement() const;

  void save(ByteWriter& state) const;
  void load(ByteReader& state);

 private:
  double steps_ = 0, e_dw_ = 0, dw2_ = 0, e2_ = 0;            // of the regression for the clock
  double gyro2_ = 0, scan2_ = 0, gyro_scan_ = 0, turns_ = 0;  // of the comparison of turns
};

}  // namespace scslam
