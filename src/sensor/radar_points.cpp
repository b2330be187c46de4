#include "scslam/sensor/radar_points.h"

namespace scslam {

void RadarParams::describe(ParamVisitor& v) {
  extractor.describe(v, "extractor", "how points are found in the power image");
}

RadarPoints::RadarPoints(const RadarParams& params, const PluginContext& context)
    : extractor_(params.extractor.create(context)) {}

Cloud RadarPoints::operator()(const RadarScan& scan) const { return extractor_->extract(scan); }

}  // namespace scslam
