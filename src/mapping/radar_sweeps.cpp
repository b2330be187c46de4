#include "scslam/mapping/radar_sweeps.h"

#include <cmath>

#include "scslam/core/error.h"
#include "scslam/sensor/sensor_tables.h"

namespace scslam {
namespace {

std::vector<AzimuthPose> posesOf(const RadarScan& image, const PoseTrack& trajectory) {
  constexpr double kStep = 0.05;  // [s], of the finite difference
  const auto step = std::chrono::duration_cast<Stamp::duration>(std::chrono::duration<double>(kStep));
  std::vector<AzimuthPose> poses(image.azimuths);
  for (std::size_t i = 0; i < image.azimuths; ++i) {
    const auto T = trajectory.at(image.stamps[i]), before = trajectory.at(image.stamps[i] - step),
               behind = trajectory.at(image.stamps[i] + step);
    if (!T || image.valid[i] == 0) continue;
    const auto place = [&image](const Pose& T_map_base) { return Pose(T_map_base * image.T_base_sensor); };
    const Pose T_map_sensor = place(*T);
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
    if (before && behind) velocity = (place(*behind).translation() - place(*before).translation()) / (2 * kStep);
    poses[i] = {
        true,        T_map_sensor.translation().x(), T_map_sensor.translation().y(), yawOf(T_map_sensor), velocity.x(),
        velocity.y()};
  }
  return poses;
}

}  // namespace

RadarSweeps::RadarSweeps(const MapInfo& info, const PluginContext& context) {
  if (info.trajectory.empty()) throw inputError("the session holds no scans");
  if (!std::filesystem::exists(info.input))
    throw inputError("a map of radar power is made from the images, but the session's input {} is not there any more",
                     info.input);
  OpenOptions options;
  options.label = info.sensor_label, options.radar = true;
  if (!info.sensor_table.empty()) options.sensor = loadSensorModel(info.sensor_table);
  source_ = openSource(info.input, context, options).source;
  for (const StampedPose& pose : info.trajectory) trajectory_.add(pose.stamp, pose.T);
  first_ = info.trajectory.front().stamp, last_ = info.trajectory.back().stamp;
}

std::optional<RadarSweeps::Sweep> RadarSweeps::next() {
  for (;;) {
    std::optional<Scan> scan;
    try {
      scan = source_->next();
    } catch (const Error& error) {
      if (error.code() != ExitCode::kInput) throw;
    }
    if (!scan) return std::nullopt;
    if (!scan->radar) throw inputError("the session's input holds no radar images: {}", source_->description());
    if (scan->stamp < first_ || scan->stamp > last_) continue;
    return Sweep{scan->radar, posesOf(*scan->radar, trajectory_)};
  }
}

}  // namespace scslam
