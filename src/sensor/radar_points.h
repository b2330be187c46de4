// The radar's box of the figure: a sweep's power image becomes a cloud.
#pragma once
#include <memory>
#include <string>

#include "scslam/core/plugin_choice.h"
#include "scslam/sensor/radar_extractor.h"
#include "scslam/sensor/radar_filter.h"

namespace scslam {

struct RadarParams : ParamSetOf<RadarParams> {
  bool prefer = false;
  PluginChoice<RadarExtractor> extractor{"k_strongest"};
  RadarFilterParams filter;
  void describe(ParamVisitor& visitor) override;
};

class RadarPoints {
 public:
  RadarPoints(const RadarParams& params, const PluginContext& context);
  /// Points of a sweep as RadarExtractor gives them, less what the filter removes.
  /// @param note what is wrong with the sweep ("37 of 400 azimuths not measured"); empty when nothing is.
  Cloud operator()(const RadarScan& sweep, std::string& note) const;

 private:
  RadarFilterParams filter_;
  std::unique_ptr<RadarExtractor> extractor_;
};

}  // namespace scslam
