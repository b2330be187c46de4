// Places as context images: which of them look like this one, and by how many columns are they shifted?
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "scslam/place/column_spectra.h"
#include "scslam/place/key_index.h"
#include "scslam/place/place_recogniser.h"

namespace scslam {

/// How heights become bin values, and what may be shifted how far.
struct ContextLayout {
  std::size_t rows = 0, columns = 0;
  bool circular = true;       ///< columns wrap around (polar); otherwise they leave the image (cart)
  std::size_t max_shift = 0;  ///< of an image that does not wrap [columns]
  bool logarithmic = false;   ///< bins hold log(1 + height): towers do not drown the rest
  double min_common = 0.5;    ///< of the columns that the scan with fewer of them saw, both must have seen this share
  /// A column counts with this power of its length: 0 all alike (the paper's mean over columns), 1 as it is (cosine of
  /// the whole images). Half of the way is best: façades and trees count for more than the road's end.
  double column_weight = 0;
};

/// An image made ready for comparison: weighted columns in the Fourier domain, retrieval key, and which columns it saw.
struct ContextProbe {
  std::vector<float> spectrum, key;
  std::vector<float> lengths2;  ///< squared length of each weighted column
  double length2 = 0;           ///< of all of them
  std::uint64_t seen = 0;       ///< bit j: column j is not empty
};

class ContextIndex {
 public:
  struct Match {
    std::size_t id = 0;
    double distance = 1;
    double shift =
        0;  ///< column j of the probe looks like column j + shift of the match; between columns, by a parabola
  };

  explicit ContextIndex(const ContextLayout& layout);

  ContextProbe probe(const Descriptor& image) const;
  void add(ContextProbe place);  ///< of the next id (0, 1, …)
  std::size_t size() const { return keys_.size(); }
  const ContextProbe& place(std::size_t id) const { return places_[id / kBlock][id % kBlock]; }

  /// Compares the probe with the `count` places of nearest key among ids 0 .. n-1 over all shifts and appends them to
  /// `matches`. Distance: 1 - cosine of both images' weighted columns, over the columns both saw (without weights: the
  /// mean over columns of the paper's Eq. 6).
  void search(const ContextProbe& probe, std::size_t n, std::size_t count, std::vector<Match>& matches) const;
  Match compare(const ContextProbe& probe, std::size_t id) const;

 private:
  static constexpr std::size_t kBlock = 256;
  /// Of a mask of columns, moved `shift` columns towards the first one, those that leave at its end come in again.
  std::uint64_t shifted(std::uint64_t columns, std::size_t shift) const;

  ContextLayout layout_;
  std::size_t period_;  ///< columns with the room that keeps shifts of a cart image from wrapping
  ColumnSpectra spectra_;
  KeyIndex keys_;
  std::vector<std::vector<ContextProbe>> places_;  ///< in blocks of kBlock: growing moves nothing
};

}  // namespace scslam
