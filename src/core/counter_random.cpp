#include "scslam/core/counter_random.h"

#include "scslam/core/simd.h"

namespace scslam {
namespace {

constexpr std::size_t kLanes = 16;

/// philox() on kLanes counters side by side.
SCSLAM_KERNEL
void drawLanes(const std::uint32_t (&start)[4][kLanes], std::array<std::uint32_t, 2> key, float* normal,
               float* uniform) {
  std::uint32_t c[4][kLanes];
  for (std::size_t word = 0; word < 4; ++word)
    for (std::size_t i = 0; i < kLanes; ++i) c[word][i] = start[word][i];
  for (int round = 0; round < 10; ++round) {
    std::uint32_t high[2][kLanes], low[2][kLanes];
    for (std::size_t i = 0; i < kLanes; ++i) {
      high[0][i] = static_cast<std::uint32_t>(std::uint64_t{kPhiloxMultiplier[0]} * c[0][i] >> 32);
      high[1][i] = static_cast<std::uint32_t>(std::uint64_t{kPhiloxMultiplier[1]} * c[2][i] >> 32);
    }
    for (std::size_t i = 0; i < kLanes; ++i)
      low[0][i] = kPhiloxMultiplier[0] * c[0][i], low[1][i] = kPhiloxMultiplier[1] * c[2][i];
    for (std::size_t i = 0; i < kLanes; ++i) {
      c[0][i] = high[1][i] ^ c[1][i] ^ key[0], c[1][i] = low[1][i];
      c[2][i] = high[0][i] ^ c[3][i] ^ key[1], c[3][i] = low[0][i];
    }
    key[0] += kPhiloxStep[0], key[1] += kPhiloxStep[1];
  }
  float x[kLanes], w[kLanes], middle[kLanes], tail[kLanes];
  for (std::size_t i = 0; i < kLanes; ++i) x[i] = InverseError::symmetricOf(c[0][i]);
  for (std::size_t i = 0; i < kLanes; ++i) w[i] = InverseError::tailOf(x[i]);
  for (std::size_t i = 0; i < kLanes; ++i) middle[i] = InverseError::middle(w[i]);
  for (std::size_t i = 0; i < kLanes; ++i) tail[i] = InverseError::tail(w[i]);
  for (std::size_t i = 0; i < kLanes; ++i) normal[i] = (w[i] < 5.0F ? middle[i] : tail[i]) * x[i];
  for (std::size_t i = 0; i < kLanes; ++i) uniform[i] = uniformOf(c[1][i]);
}

}  // namespace

void CounterRandom::drawColumn(std::uint32_t scan, std::uint32_t column, std::size_t n, float* normal,
                               float* uniform) const {
  for (std::size_t first = 0; first < n; first += kLanes) {
    std::uint32_t start[4][kLanes];
    for (std::size_t i = 0; i < kLanes; ++i) {
      start[0][i] = scan, start[1][i] = column;
      start[2][i] = static_cast<std::uint32_t>(first + i), start[3][i] = 0;
    }
    float normals[kLanes], uniforms[kLanes];
    drawLanes(start, key_, normals, uniforms);
    const std::size_t many = std::min(kLanes, n - first);
    std::copy_n(normals, many, normal + first);
    std::copy_n(uniforms, many, uniform + first);
  }
}

}  // namespace scslam
