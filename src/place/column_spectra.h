// Column-wise cosine similarity of two images for every circular shift of their columns at once.
//
// The sum over columns of a(j) . b(j + s) is a circular cross-correlation, summed over the rows. In the Fourier domain
// it costs a product per frequency instead of one per shift: 20 x 60 images and all 60 shifts take about 6 000
// multiplications instead of 72 000. Exact but for the rounding of single precision (about 1e-6).
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "scslam/place/float8.h"

namespace scslam {

class ColumnSpectra {
 public:
  static constexpr std::size_t kMaxColumns = 64;

  /// @param columns of the images, 2 .. kMaxColumns; shifts wrap around.
  ColumnSpectra(std::size_t rows, std::size_t columns);

  std::size_t columns() const { return columns_; }
  /// Floats of one image's spectrum.
  std::size_t size() const { return groups_ * rows_ * 2 * kLanes; }
  /// @param image row-major rows x columns.
  void transform(const float* image, std::span<float> spectrum) const;
  /// similarity[s] = sum over columns j of a(:, j) . b(:, (j + s) mod columns), s = 0 .. columns - 1.
  void correlate(const float* a, const float* b, float (&similarity)[kMaxColumns]) const;

 private:
  std::size_t rows_, columns_, frequencies_, groups_;  ///< groups of kLanes frequencies
  /// forward_[group][column][cos | sin][lane]; inverse_[group of shifts][frequency][cos | sin][lane], weighted.
  std::vector<float> forward_, inverse_;
};

}  // namespace scslam
