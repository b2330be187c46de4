// From a radar's power image to points. One file in extractors/ per method.
#pragma once
#include "scslam/core/cloud.h"
#include "scslam/core/registry.h"
#include "scslam/sensor/radar_scan.h"

namespace scslam {

/// Plug-in interface of sensor/extractors.
class RadarExtractor {
 public:
  static constexpr const char* kKind = "radar point extractor";
  virtual ~RadarExtractor() = default;
  /// Points in the sensor frame, z = 0, azimuth by azimuth and outwards; intensity = power (0 … 255), ring = azimuth,
  /// dt = seconds after the first azimuth's stamp. Azimuths that are not valid give none. Never throws for odd images.
  virtual Cloud extract(const RadarScan& scan) const = 0;
};
SCSLAM_DECLARE_REGISTRY(RadarExtractor);

}  // namespace scslam
