#include "scslam/sensor/preprocess.h"

#include <cmath>
#include <cstdint>

#include "scslam/core/error.h"

namespace scslam {

void PreprocessParams::describe(ParamVisitor& v) {
  v.field("min_range_m", min_range_m, "nearer returns are dropped [m]", 0.0, 1000.0);
  v.field("max_range_m", max_range_m, "farther returns are dropped [m]", 0.1, 100'000.0);
  v.field("self_box_m", self_box_m,
          "the robot's own box in the base frame, whose returns are dropped: x_min x_max y_min y_max z_min z_max [m]");
}

namespace {

class Box {
 public:
  Box(const std::vector<double>& limits, const Pose& T_base_sensor)
      : used_(!limits.empty()), T_base_sensor_(T_base_sensor.cast<float>()) {
    if (used_ && limits.size() != 6)
      throw usageError("self_box_m has {} numbers, not 6 (x_min x_max y_min y_max z_min z_max)", limits.size());
    for (int i = 0; used_ && i < 3; ++i) {
      low_[i] = static_cast<float>(limits[2 * static_cast<std::size_t>(i)]);
      high_[i] = static_cast<float>(limits[2 * static_cast<std::size_t>(i) + 1]);
    }
  }
  bool contains(const Eigen::Vector3f& p_sensor) const {
    if (!used_) return false;
    const Eigen::Vector3f p = T_base_sensor_ * p_sensor;
    return (p.array() >= low_.array()).all() && (p.array() <= high_.array()).all();
  }

 private:
  bool used_;
  Eigen::Isometry3f T_base_sensor_;
  Eigen::Vector3f low_ = Eigen::Vector3f::Zero(), high_ = Eigen::Vector3f::Zero();
};

}  // namespace

PreprocessReport preprocess(Scan& scan, const PreprocessParams& params, const SensorModel* table) {
  Cloud& cloud = scan.cloud;
  PreprocessReport report;
  report.input = cloud.size();
  if (table != nullptr) report.completed = completeFromTable(cloud, *table);
  const Box robot(params.self_box_m, scan.T_base_sensor);
  const double near2 = params.min_range_m * params.min_range_m, far2 = params.max_range_m * params.max_range_m;
  std::vector<std::uint8_t> keep(cloud.size(), 1);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f p = cloud.point(i);
    const double range2 = p.cast<double>().squaredNorm();
    if (!std::isfinite(range2))
      ++report.non_finite, keep[i] = 0;
    else if (range2 < near2 || range2 > far2)
      ++report.out_of_range, keep[i] = 0;
    else if (robot.contains(p))
      ++report.on_robot, keep[i] = 0;
  }
  report.kept = report.input - report.non_finite - report.out_of_range - report.on_robot;
  if (report.kept != report.input) cloud.filter(keep);
  return report;
}

Cloud cloudInBase(const Scan& scan) { return transformed(scan.cloud, scan.T_base_sensor); }

}  // namespace scslam
