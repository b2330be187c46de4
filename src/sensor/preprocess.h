// What happens to every scan before odometry sees it.
#pragma once
#include <string>
#include <vector>

#include "scslam/core/params.h"
#include "scslam/sensor/scan.h"
#include "scslam/sensor/sensor_model.h"

namespace scslam {

struct PreprocessParams : ParamSetOf<PreprocessParams> {
  double min_range_m = 0.5;
  double max_range_m = 120.0;
  std::vector<double> self_box_m;  ///< of the robot in frame base: x_min x_max y_min y_max z_min z_max; empty = none

  void describe(ParamVisitor& visitor) override;
};

struct PreprocessReport {
  std::size_t input = 0;
  std::size_t non_finite = 0;    ///< NaN or infinite: no return
  std::size_t out_of_range = 0;  ///< distance from the sensor; the zeros of sensors that mark missing returns so, too
  std::size_t on_robot = 0;      ///< inside self_box_m
  std::size_t kept = 0;
  std::string completed;  ///< what completeFromTable made, in words
};

/// Completes rings and times from `table` (where given, and before points are dropped: it counts them), then drops what
/// is no finite point, out of range, or the robot itself. The cloud stays in the sensor frame and keeps its order.
/// @throw usageError when self_box_m has neither 0 nor 6 numbers.
PreprocessReport preprocess(Scan& scan, const PreprocessParams& params, const SensorModel* table = nullptr);

/// The cloud in frame base.
Cloud cloudInBase(const Scan& scan);

}  // namespace scslam
