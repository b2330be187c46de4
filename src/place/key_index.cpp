#include "scslam/place/key_index.h"

#include <algorithm>

#include "scslam/core/simd.h"
#include "scslam/place/float8.h"

namespace scslam {
namespace {

/// Squared distances of `key` to the first n keys of a block (n rounded up to 32).
SCSLAM_KERNEL void distances(const float* key, const float* block, std::size_t dimensions, std::size_t stride,
                             std::size_t n, float* out) {
  for (std::size_t i = 0; i < n; i += 32) {
    Float8 sum[4] = {};
    for (std::size_t d = 0; d < dimensions; ++d) {
      const float* row = block + d * stride + i;
      for (std::size_t lane = 0; lane < 4; ++lane) {
        Float8 value;
        load8(value, row + kLanes * lane);
        value -= key[d];
        sum[lane] += value * value;
      }
    }
    std::memcpy(out + i, sum, sizeof sum);
  }
}

}  // namespace

void KeyIndex::add(const float* key) {
  const std::size_t at = size_ % kBlock;
  if (at == 0) blocks_.push_back(std::make_unique<float[]>(dimensions_ * kBlock));
  for (std::size_t d = 0; d < dimensions_; ++d) blocks_.back()[d * kBlock + at] = key[d];
  ++size_;
}

void KeyIndex::nearest(const float* key, std::size_t n, std::size_t count, std::vector<Neighbour>& found) const {
  found.clear();
  n = std::min(n, size_);
  if (n == 0 || count == 0) return;
  float distance2[kBlock];
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    const std::size_t here = std::min(kBlock, n - begin);
    distances(key, blocks_[begin / kBlock].get(), dimensions_, kBlock, here, distance2);
    // `found` is a heap whose front is the worst kept; a later key at the same distance has the larger id: not better.
    for (std::size_t i = 0; i < here; ++i) {
      if (found.size() == count) {
        if (distance2[i] >= found.front().distance2) continue;
        std::pop_heap(found.begin(), found.end());
        found.pop_back();
      }
      found.push_back({distance2[i], begin + i});
      std::push_heap(found.begin(), found.end());
    }
  }
  std::sort_heap(found.begin(), found.end());
}

}  // namespace scslam
