#include "scslam/sensor/sensor_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace scslam {

void SensorModel::describe(ParamVisitor& v) {
  v.field("name", name, "what it is, for messages");
  v.field("rings", rings, "lasers; 0 = unknown", 0, 1024);
  v.field("columns", columns, "firings a sweep; 0 = unknown", 0, 1'000'000);
  v.field("order", order, "how the points of an organised cloud follow each other",
          {"column_major", "row_major", "unorganised"});
  v.field("sweep_s", sweep_s, "duration of one sweep [s]", 1e-4, 60.0);
  v.field("clockwise", clockwise, "direction of rotation seen from above");
  v.field("min_range_m", min_range_m, "nearer returns are the robot itself or none [m]", 0.0, 1000.0);
  v.field("max_range_m", max_range_m, "farther returns are not believed [m]", 0.1, 10000.0);
  v.field("elevation_deg", elevation_deg, "elevation of each ring, lowest first [deg]; may be empty");
  v.field("translation_m", translation_m, "position of the sensor in the base frame: x y z [m]");
  v.field("rpy_deg", rpy_deg, "roll, pitch, yaw of the sensor in the base frame [deg]; R = Rz(yaw) Ry(pitch) Rx(roll)");
  v.group("beams", beams, "where and when each beam leaves");
  v.group("signal", signal, "strength, noise and loss of echoes");
  v.group("radar", radar, "a spinning radar's image");
}

Pose SensorModel::T_base_sensor() const {
  const auto rad = [this](std::size_t i) { return rpy_deg.at(i) * M_PI / 180; };
  Pose T = Pose::Identity();
  T.linear() =
      (Eigen::AngleAxisd(rad(2), Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(rad(1), Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(rad(0), Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  T.translation() = Eigen::Vector3d(translation_m.at(0), translation_m.at(1), translation_m.at(2));
  return T;
}

namespace {

/// Ring and column of point k; false when the cloud is not organised as the table says.
struct Grid {
  bool column_major;
  std::size_t rings, columns;
  std::size_t ring(std::size_t k) const { return column_major ? k % rings : k / columns; }
  std::size_t column(std::size_t k) const { return column_major ? k / rings : k % columns; }
};

bool organised(const Cloud& cloud, const SensorModel& sensor, Grid& grid) {
  const auto rings = static_cast<std::size_t>(sensor.rings);
  if (rings == 0 || cloud.empty() || cloud.size() % rings != 0) return false;
  if (sensor.order != "column_major" && sensor.order != "row_major") return false;
  grid = {sensor.order == "column_major", rings, cloud.size() / rings};
  // A cloud of some other number of columns by row is another sensor; by column it may be a cut sweep.
  return grid.column_major || sensor.columns == 0 || grid.columns == static_cast<std::size_t>(sensor.columns);
}

}  // namespace

std::string completeFromTable(Cloud& cloud, const SensorModel& sensor) {
  Grid grid{};
  if (!organised(cloud, sensor, grid)) return "";
  std::string made;
  if (!cloud.hasRing()) {
    cloud.ring.resize(cloud.size());
    for (std::size_t k = 0; k < cloud.size(); ++k) cloud.ring[k] = static_cast<std::uint16_t>(grid.ring(k));
    made =
        grid.column_major ? fmt::format("ring = k mod {}", grid.rings) : fmt::format("ring = k div {}", grid.columns);
  }
  if (!cloud.hasTime()) {
    const auto columns = std::max(grid.columns, static_cast<std::size_t>(sensor.columns));
    cloud.dt.resize(cloud.size());
    for (std::size_t k = 0; k < cloud.size(); ++k)
      cloud.dt[k] =
          static_cast<float>(sensor.sweep_s * static_cast<double>(grid.column(k)) / static_cast<double>(columns));
    made += made.empty() ? "time by column" : ", time by column";
  }
  return made;
}

}  // namespace scslam
