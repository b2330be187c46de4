// Binary descriptors of places in a radar image: which of two spots nearby is brighter, 256 times (BRIEF: M. Calonder
// et al., ECCV 2010). They are taken from the polar image itself: no Cartesian picture of a quarter million pixels is
// made.
#pragma once
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "scslam/core/parallel.h"
#include "scslam/odometry/odometry.h"

namespace scslam::radar_features {

using Descriptor = std::array<std::uint64_t, 4>;

inline int distanceOf(const Descriptor& a, const Descriptor& b) {
  int bits = 0;
  for (std::size_t k = 0; k < a.size(); ++k) bits += std::popcount(a[k] ^ b[k]);
  return bits;
}

/// Power of a sweep at any place of the sensor's plane, smoothed over cells along the range.
class PowerField {
 public:
  PowerField() = default;
  /// @param cell_m size of the cells [m].
  PowerField(const RadarScan& scan, double cell_m);
  /// Between the four nearest values; 0 beyond the image.
  float at(float x, float y) const;

 private:
  std::size_t rows_ = 0, cells_ = 0;
  float first_rad_ = 0, rows_per_rad_ = 0, offset_m_ = 0, cells_per_m_ = 0;
  std::vector<float> power_;
};

/// Places in the sensor's plane [m].
struct Places {
  std::vector<float> x, y;
};

/// @param radius_m of the patch around each place. @param turn_rad the patches are turned so far, counter-clockwise.
std::vector<Descriptor> describe(const PowerField& field, const Places& places, double radius_m, double turn_rad,
                                 ThreadPool& threads);

}  // namespace scslam::radar_features
