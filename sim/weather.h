// Rain and fog as a LiDAR sees them: echoes weaken, and the air itself answers.
#pragma once
#include <cstdint>

#include "scslam/core/params.h"

namespace scslam::sim {

/// YAML group `weather` of a scenario.
struct Weather : ParamSetOf<Weather> {
  double fog_per_m = 0;  ///< extinction alpha [1/m]; visibility = 3 / alpha. 0.06 is thick fog
  double rain_mm_per_h = 0;
  void describe(ParamVisitor& visitor) override;

  bool clear() const { return fog_per_m <= 0 && rain_mm_per_h <= 0; }
  /// alpha of fog and rain together [1/m]. Rain: 1.076 R^0.67 dB/km (Carbonneau and Wisely 1998).
  double extinction() const;
  /// An echo of fog or of a drop nearer than `range` [m]: its range, or 0. u: three numbers in (0, 1).
  /// Fog answers with a soft echo out of its first metres, drops one by one.
  double airEcho(double range, const float u[3]) const;
};

}  // namespace scslam::sim
