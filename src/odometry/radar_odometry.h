// What the radar front-ends share: sweeps of a quarter of a second in which the car moves by metres and every range is
// shifted by the Doppler effect, and motion that is known in the plane only.
#pragma once
#include "scslam/odometry/scan_to_map.h"

namespace scslam {

struct RadarOdometryParams : ScanToMapParams {
  double climb = 0.03;
  double tilt_deg = 0.5;
  RadarOdometryParams() {
    max_range_m = 150;
    deskew = "on";  // the azimuths' stamps are the sensor's own
  }
  void describeRadar(ParamVisitor& visitor);
};

class RadarOdometry : public ScanToMap {
 protected:
  RadarOdometry(const RadarOdometryParams& params, const PluginContext& context)
      : ScanToMap(params, context), climb_(params.climb), tilt_deg_(params.tilt_deg) {}

  /// To be called from extract(): whose ranges compensate() corrects.
  void noteSensor(const Scan& scan);
  const Pose& sensor() const { return T_base_sensor_; }

  /// Ranges first: a sensor that moves at v sees what lies in direction u nearer by doppler_beta_s * v . u.
  void compensate(Cloud& cloud, const Vector6d& twist) const override;
  bool slowSweeps() const override { return true; }
  /// SE(2) lifted to SE(3): the ground may climb, the car may tilt, and the radar sees neither.
  OffPlane offPlane(const Pose& T_previous_base) const override;

 private:
  double climb_, tilt_deg_;
  Pose T_base_sensor_ = Pose::Identity();  ///< of the present scan
  double doppler_beta_s_ = 0;
};

/// Adds doppler_beta_s * v . u to the range of each point, v = the sensor's velocity at the point's own instant.
/// @param cloud frame base at the point's instant. @param twist of the base during the sweep (deskew.h).
void undoDoppler(Cloud& cloud, const Pose& T_base_sensor, double doppler_beta_s, const Vector6d& twist);

}  // namespace scslam
