// The radar's box of the figure: a sweep's power image becomes a cloud.
#pragma once
#include <memory>

#include "scslam/core/plugin_choice.h"
#include "scslam/sensor/radar_extractor.h"

namespace scslam {

struct RadarParams : ParamSetOf<RadarParams> {
  PluginChoice<RadarExtractor> extractor{"k_strongest"};
  void describe(ParamVisitor& visitor) override;
};

class RadarPoints {
 public:
  RadarPoints(const RadarParams& params, const PluginContext& context);
  /// Points of a sweep as RadarExtractor gives them.
  Cloud operator()(const RadarScan& scan) const;

 private:
  std::unique_ptr<RadarExtractor> extractor_;
};

}  // namespace scslam
