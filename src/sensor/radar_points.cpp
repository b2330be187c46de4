#include "scslam/sensor/radar_points.h"

#include <fmt/format.h>

#include <algorithm>

namespace scslam {

void RadarParams::describe(ParamVisitor& v) {
  v.field("prefer", prefer, "of a recording with a LiDAR and a radar, take the radar");
  extractor.describe(v, "extractor", "how points are found in the power image");
  v.group("filter", filter, "what is taken from them again");
}

RadarPoints::RadarPoints(const RadarParams& params, const PluginContext& context)
    : filter_(params.filter), extractor_(params.extractor.create(context)) {}

Cloud RadarPoints::operator()(const RadarScan& sweep, std::string& note) const {
  Cloud cloud = extractor_->extract(sweep);
  const bool nothing = cloud.empty();
  const RadarFilterReport report = filterRadarPoints(cloud, sweep, filter_);
  const auto lost = static_cast<std::size_t>(std::count(sweep.valid.begin(), sweep.valid.end(), 0));
  note.clear();
  const auto add = [&note](const std::string& text) { note += (note.empty() ? "" : ", ") + text; };
  if (lost != 0) add(fmt::format("{} of {} azimuths not measured", lost, sweep.azimuths));
  if (report.raised_azimuths > sweep.azimuths / 20)  // a strong echo raises its own
    add(fmt::format("{} azimuths with saturation streaks", report.raised_azimuths));
  if (nothing) add("no echo in it");
  return cloud;
}

}  // namespace scslam
