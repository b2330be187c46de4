#include "scslam/place/column_spectra.h"

#include <algorithm>
#include <cmath>

#include "scslam/core/simd.h"
#include "scslam/place/float8.h"

namespace scslam {
namespace {

constexpr std::size_t kMaxGroups = 5;  // 33 frequencies of 64 columns

SCSLAM_KERNEL void forward(const float* image, const float* table, std::size_t rows, std::size_t columns,
                           std::size_t groups, float* spectrum) {
  for (std::size_t group = 0; group < groups; ++group)
    for (std::size_t row = 0; row < rows; ++row) {
      Float8 re = {}, im = {}, c, s;
      for (std::size_t j = 0; j < columns; ++j) {
        const float value = image[row * columns + j];
        const float* angle = table + (group * columns + j) * 16;
        load8(c, angle), load8(s, angle + 8);
        re += value * c;
        im -= value * s;
      }
      float* out = spectrum + (group * rows + row) * 16;
      store8(out, re), store8(out + 8, im);
    }
}

/// Cross spectrum conj(A) B summed over the rows, then its inverse for shifts 0 .. columns / 2, even and odd part
/// apart.
SCSLAM_KERNEL void crossCorrelate(const float* a, const float* b, const float* table, std::size_t rows,
                                  std::size_t frequencies, std::size_t groups, float* even, float* odd) {
  float cross[2][kMaxGroups * 8];
  for (std::size_t group = 0; group < groups; ++group) {
    Float8 re = {}, im = {}, ar, ai, br, bi;
    for (std::size_t row = 0; row < rows; ++row) {
      const std::size_t at = (group * rows + row) * 16;
      load8(ar, a + at), load8(ai, a + at + 8), load8(br, b + at), load8(bi, b + at + 8);
      re += ar * br + ai * bi;
      im += ar * bi - ai * br;
    }
    store8(cross[0] + group * 8, re), store8(cross[1] + group * 8, im);
  }
  for (std::size_t group = 0; group < groups; ++group) {
    Float8 e = {}, o = {}, c, s;
    for (std::size_t f = 0; f < frequencies; ++f) {
      const float* angle = table + (group * frequencies + f) * 16;
      load8(c, angle), load8(s, angle + 8);
      e += cross[0][f] * c;
      o += cross[1][f] * s;
    }
    store8(even + group * 8, e), store8(odd + group * 8, o);
  }
}

}  // namespace

ColumnSpectra::ColumnSpectra(std::size_t rows, std::size_t columns)
    : rows_(rows), columns_(columns), frequencies_(columns / 2 + 1), groups_((frequencies_ + kLanes - 1) / kLanes) {
  forward_.assign(groups_ * columns_ * 2 * kLanes, 0.0f);
  inverse_.assign(groups_ * frequencies_ * 2 * kLanes, 0.0f);
  const auto angle = [this](std::size_t a, std::size_t b) {
    return 2 * M_PI * static_cast<double>(a * b % columns_) / static_cast<double>(columns_);
  };
  for (std::size_t f = 0; f < frequencies_; ++f) {
    for (std::size_t j = 0; j < columns_; ++j) {
      float* at = &forward_[(f / kLanes * columns_ + j) * 2 * kLanes + f % kLanes];
      at[0] = static_cast<float>(std::cos(angle(f, j))), at[kLanes] = static_cast<float>(std::sin(angle(f, j)));
    }
    // Frequencies that stand for two (f and columns - f) count twice.
    const bool single = f == 0 || 2 * f == columns_;
    const double weight = (single ? 1.0 : 2.0) / static_cast<double>(columns_);
    for (std::size_t s = 0; 2 * s <= columns_; ++s) {
      float* at = &inverse_[(s / kLanes * frequencies_ + f) * 2 * kLanes + s % kLanes];
      at[0] = static_cast<float>(weight * std::cos(angle(f, s)));
      at[kLanes] = static_cast<float>(weight * std::sin(angle(f, s)));
    }
  }
}

void ColumnSpectra::transform(const float* image, std::span<float> spectrum) const {
  forward(image, forward_.data(), rows_, columns_, groups_, spectrum.data());
}

void ColumnSpectra::correlate(const float* a, const float* b, float (&similarity)[kMaxColumns]) const {
  float even[kMaxGroups * kLanes], odd[kMaxGroups * kLanes];
  crossCorrelate(a, b, inverse_.data(), rows_, frequencies_, groups_, even, odd);
  for (std::size_t s = 0; 2 * s <= columns_; ++s) {
    similarity[s] = even[s] - odd[s];  // NOLINT(clang-analyzer-core.UndefinedBinaryOperatorResult): filled just now
    similarity[(columns_ - s) % columns_] = even[s] + odd[s];
  }
  similarity[0] = even[0];
}

}  // namespace scslam
