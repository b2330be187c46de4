// What an inertial sensor says about the motion between two instants, independent of where it started.
//
// Readings are taken as linear between samples. With a = start, b = end of the interval and the gravity vector g:
//
//   R_b = R_a dR,   v_b = v_a + g T + R_a dv,   p_b = p_a + v_a T + g T^2 / 2 + R_a dp
//
// (Forster et al., "On-Manifold Preintegration for Real-Time Visual-Inertial Odometry", T-RO 2017; rotation by the
// Magnus expansion to fourth order, velocity and position by Simpson's rule over the rotated force.)
#pragma once
#include <vector>

#include "scslam/core/bytes.h"
#include "scslam/core/params.h"
#include "scslam/core/pose.h"

namespace scslam {

using Matrix9d = Eigen::Matrix<double, 9, 9>;

struct ImuBias {
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();   ///< [rad/s]
  Eigen::Vector3d accel = Eigen::Vector3d::Zero();  ///< [m/s^2]
};

/// Noise densities; defaults of a MEMS unit on a vehicle: about ten times those of its data sheet, for what a data
/// sheet leaves out (scale, alignment, vibration, stamps).
struct ImuNoise : ParamSetOf<ImuNoise> {
  double gyro = 2e-3;        ///< [rad/s/sqrt(Hz)]
  double accel = 2e-2;       ///< [m/s^2/sqrt(Hz)]
  double gyro_walk = 2e-5;   ///< [rad/s^2/sqrt(Hz)]
  double accel_walk = 2e-4;  ///< [m/s^3/sqrt(Hz)]
  void describe(ParamVisitor& visitor) override;
};

/// A reading t seconds after the start of an interval.
struct ImuReading {
  double t = 0;
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();   ///< [rad/s]
  Eigen::Vector3d accel = Eigen::Vector3d::Zero();  ///< specific force [m/s^2]
};

/// Motion relative to the start, without its velocity and without gravity.
struct ImuMotion {
  double duration_s = 0;
  Eigen::Matrix3d dR = Eigen::Matrix3d::Identity();
  Eigen::Vector3d dv = Eigen::Vector3d::Zero();
  Eigen::Vector3d dp = Eigen::Vector3d::Zero();

  /// This motion, then `next`.
  ImuMotion then(const ImuMotion& next) const;
};

/// The motion between two readings that follow each other, biases removed.
ImuMotion motionBetween(const ImuReading& a, const ImuReading& b, const ImuBias& bias);

/// Position, attitude and velocity of the sensor's frame, in a frame that does not turn.
struct NavState {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Vector3d v = Eigen::Vector3d::Zero();

  NavState after(const ImuMotion& motion, const Eigen::Vector3d& gravity) const;
};

/// Motion over an interval with what is needed to use it as one factor.
class ImuPreintegration {
 public:
  /// @param readings at least two, in order of time, the first at the start, the last at the end.
  ImuPreintegration(const std::vector<ImuReading>& readings, const ImuBias& bias, const ImuNoise& noise);

  const ImuBias& bias() const { return bias_; }
  /// What it was made from.
  const std::vector<ImuReading>& readings() const { return readings_; }
  const ImuMotion& motion() const { return motion_; }
  /// The motion for another bias, to first order.
  ImuMotion motion(const ImuBias& bias) const;

  // Derivatives by the biases; that of dR is the right perturbation: dR(b + d) = dR(b) Exp(J d).
  Eigen::Matrix3d dR_dgyro = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d dv_dgyro = Eigen::Matrix3d::Zero(), dv_daccel = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d dp_dgyro = Eigen::Matrix3d::Zero(), dp_daccel = Eigen::Matrix3d::Zero();
  /// Of (dp, dR as a right perturbation, dv), from white noise; the walk of the biases is not in it.
  Matrix9d covariance = Matrix9d::Zero();

 private:
  void add(const ImuReading& a, const ImuReading& b, const ImuNoise& noise);
  std::vector<ImuReading> readings_;
  ImuBias bias_;
  ImuMotion motion_;
};

}  // namespace scslam
