#include "sim/navigation_sensor.h"

#include <cmath>

#include "scslam/core/error.h"

namespace scslam::sim {

void NavigationSensor::upTo(double t, const ObservationSink& sink) {
  for (double now = nextTime(); now <= t && std::isfinite(now); now = nextTime()) {
    const auto observation = measure(index_++, now);
    if (!observation) continue;
    observation->timestamp = stampAt(now);
    sink(observation);
  }
}

Stamp NavigationSensor::stampAt(double t) const {
  constexpr double kTicksPerSecond = 1e7;
  return start_ + Stamp::duration(std::llround(t * kTicksPerSecond));
}

Eigen::Vector3d threeOf(const std::vector<double>& list, const std::string& sensor, const char* key) {
  if (list.size() != 3 || !std::isfinite(list[0]) || !std::isfinite(list[1]) || !std::isfinite(list[2]))
    throw usageError("{}: {} needs three finite numbers, as in [0, 0, 1.5]", sensor, key);
  return {list[0], list[1], list[2]};
}

Pose mounting(const std::vector<double>& translation_m, const std::vector<double>& rpy_deg, const std::string& sensor) {
  const Eigen::Vector3d rpy = threeOf(rpy_deg, sensor, "rpy_deg") * M_PI / 180;
  Pose T_base_sensor = Pose::Identity();
  T_base_sensor.translation() = threeOf(translation_m, sensor, "translation_m");
  T_base_sensor.linear() =
      (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  return T_base_sensor;
}

}  // namespace scslam::sim
