#include "scslam/odometry/frontends/radar_features/descriptors.h"

#include <algorithm>
#include <cmath>

#include "scslam/core/counter_random.h"

namespace scslam::radar_features {
namespace {

constexpr std::size_t kBits = 256;

struct Spots {
  float ax, ay, bx, by;  ///< in patch radii
};

/// Gaussian about the patch's middle, as the paper found best.
const std::array<Spots, kBits>& pattern() {
  static const std::array<Spots, kBits> spots = [] {
    RandomSequence random(CounterRandom(1, RandomStream::kRadar), 2);
    const auto coordinate = [&random] { return static_cast<float>(std::clamp(0.4 * random.normal(), -1.0, 1.0)); };
    std::array<Spots, kBits> made{};
    for (Spots& pair : made)
      pair.ax = coordinate(), pair.ay = coordinate(), pair.bx = coordinate(), pair.by = coordinate();
    return made;
  }();
  return spots;
}

}  // namespace

PowerField::PowerField(const RadarScan& scan, double cell_m) {
  if (!scan.consistent() || scan.azimuths < 4 || !(scan.range_resolution_m > 0)) return;
  const auto bins = static_cast<std::size_t>(std::max(1.0, std::round(cell_m / scan.range_resolution_m)));
  rows_ = scan.azimuths, cells_ = scan.bins / bins;
  if (cells_ == 0) return;
  first_rad_ = static_cast<float>(scan.angles[0]);
  // Encoders turn evenly, either way round.
  const double quarter = std::remainder(scan.angles[rows_ / 4] - scan.angles[0], 2 * M_PI);
  rows_per_rad_ = static_cast<float>(static_cast<double>(rows_) / (quarter < 0 ? -2 * M_PI : 2 * M_PI));
  cells_per_m_ = static_cast<float>(1 / (static_cast<double>(bins) * scan.range_resolution_m));
  offset_m_ = static_cast<float>(scan.range_offset_m);
  power_.resize(rows_ * cells_);
  for (std::size_t row = 0; row < rows_; ++row)
    for (std::size_t cell = 0; cell < cells_; ++cell) {
      std::uint32_t sum = 0;
      for (std::size_t i = cell * bins; i < (cell + 1) * bins; ++i) sum += scan.row(row)[i];
      power_[row * cells_ + cell] = static_cast<float>(sum) / static_cast<float>(bins);
    }
}

float PowerField::at(float x, float y) const {
  if (power_.empty()) return 0;
  const float column = (std::sqrt(x * x + y * y) - offset_m_) * cells_per_m_ - 0.5f;
  if (!(column >= 0) || column >= static_cast<float>(cells_ - 1)) return 0;
  const auto n = static_cast<float>(rows_);
  float row = (std::atan2(-y, x) - first_rad_) * rows_per_rad_;  // the encoder counts clockwise
  row = std::clamp(row - n * std::floor(row / n), 0.0f, std::nextafter(n, 0.0f));
  const auto r = static_cast<std::size_t>(row), c = static_cast<std::size_t>(column);
  const float u = row - static_cast<float>(r), v = column - static_cast<float>(c);
  const float* here = &power_[r * cells_ + c];
  const float* next = &power_[(r + 1) % rows_ * cells_ + c];
  return (1 - u) * ((1 - v) * here[0] + v * here[1]) + u * ((1 - v) * next[0] + v * next[1]);
}

std::vector<Descriptor> describe(const PowerField& field, const Places& places, double radius_m, double turn_rad,
                                 ThreadPool& threads) {
  const auto c = static_cast<float>(radius_m * std::cos(turn_rad)),
             s = static_cast<float>(radius_m * std::sin(turn_rad));
  std::vector<Descriptor> descriptors(places.x.size());
  constexpr std::size_t kChunk = 64;
  threads.forEachChunk(places.x.size(), kChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto at = [&](float px, float py) {
        return field.at(places.x[i] + c * px - s * py, places.y[i] + s * px + c * py);
      };
      for (std::size_t bit = 0; bit < kBits; ++bit) {
        const Spots& pair = pattern()[bit];
        if (at(pair.ax, pair.ay) < at(pair.bx, pair.by)) descriptors[i][bit / 64] |= std::uint64_t{1} << (bit % 64);
      }
    }
  });
  return descriptors;
}

}  // namespace scslam::radar_features
