#include "sim/weather.h"

#include <algorithm>
#include <cmath>

namespace scslam::sim {

void Weather::describe(ParamVisitor& v) {
  v.field("fog_per_m", fog_per_m, "extinction of fog [1/m]; visibility is 3 / this", 0, 1);
  v.field("rain_mm_per_h", rain_mm_per_h, "rain [mm/h]", 0, 500);
}

double Weather::extinction() const {
  const double rain_db_per_km = rain_mm_per_h > 0 ? 1.076 * std::pow(rain_mm_per_h, 0.67) : 0;
  return fog_per_m + rain_db_per_km / 1000 / (10 * std::log10(std::exp(1.0)));
}

double Weather::airEcho(double range, const float u[3]) const {
  // Fog: the share of beams whose soft echo is the strongest grows with alpha and with the distance of the hard target;
  // it comes from where the receiver begins to see, exponentially rarer with range.
  const double fog_share = 1 - std::exp(-fog_per_m * std::min(range, 30.0) * 0.5);
  if (fog_per_m > 0 && static_cast<double>(u[0]) < fog_share) {
    const double r = 1.5 - std::log(static_cast<double>(u[1])) / (4 * fog_per_m + 0.2);
    return r < range ? r : 0;
  }
  // Drops: 0.1 % of beams meet one that answers within 15 m at 10 mm/h.
  const double drop_share = 0.001 * std::pow(rain_mm_per_h / 10, 0.6) * std::min(range, 15.0) / 15;
  if (rain_mm_per_h > 0 && static_cast<double>(u[2]) < drop_share)
    return 1 + static_cast<double>(u[1]) * (std::min(range, 15.0) - 1);
  return 0;
}

}  // namespace scslam::sim
