// A radar sweep as an observation of an MRPT rawlog.
#pragma once
#include <mrpt/obs/CObservation.h>

#include "scslam/sensor/radar_scan.h"

namespace scslam {

/// MRPT 2.5 has no class for radar images. Programs that know this one read it from rawlogs
/// ("scslam::CObservationRadar"); others stop there with "class not registered". `timestamp` is the first row's,
/// `sensorLabel` the scan's.
class CObservationRadar : public mrpt::obs::CObservation {
  DEFINE_SERIALIZABLE(CObservationRadar, scslam)

 public:
  CObservationRadar() = default;
  /// @throw inputError for a scan that readers would refuse (see limits in radar_observation.cpp).
  explicit CObservationRadar(RadarScan radar_scan);

  RadarScan scan;

  void getSensorPose(mrpt::poses::CPose3D& T_base_sensor) const override;
  void setSensorPose(const mrpt::poses::CPose3D& T_base_sensor) override;
  void getDescriptionAsText(std::ostream& out) const override;
};

}  // namespace scslam
