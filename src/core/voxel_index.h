// A flat open-addressing hash from voxel keys to dense numbers 0..size()-1: the payload lives in the owner's own
// arrays.
#pragma once
#include <cstddef>
#include <vector>

#include "scslam/core/voxel_key.h"

namespace scslam {

/// Linear probing, at most half full, 16-byte slots (four a cache line), no tombstones: an erased slot is closed by
/// shifting its followers back, so look-ups never slow down in a map whose far end is forgotten all the time.
class VoxelIndex {
 public:
  static constexpr std::uint32_t kAbsent = ~std::uint32_t{0};

  explicit VoxelIndex(std::size_t expected = 0) { reserve(expected); }

  std::size_t size() const { return keys_.size(); }
  /// Keys by dense number.
  const std::vector<VoxelKey>& keys() const { return keys_; }

  std::uint32_t find(VoxelKey key) const {
    for (std::size_t slot = home(key);; slot = (slot + 1) & mask_) {
      if (slots_[slot].key == key) return slots_[slot].value;
      if (slots_[slot].key == kNoVoxel) return kAbsent;
    }
  }
  /// Asks for the cache line that find(key) will read.
  void prefetch(VoxelKey key) const { __builtin_prefetch(&slots_[home(key)]); }

  /// @return the voxel's dense number; a new voxel gets size() as it was before.
  std::uint32_t findOrInsert(VoxelKey key) {
    std::size_t slot = home(key);
    for (;; slot = (slot + 1) & mask_) {
      if (slots_[slot].key == key) return slots_[slot].value;
      if (slots_[slot].key == kNoVoxel) break;
    }
    const auto value = static_cast<std::uint32_t>(keys_.size());
    slots_[slot] = {key, value};
    keys_.push_back(key);
    if (2 * keys_.size() > slots_.size()) rehash(2 * slots_.size());
    return value;
  }

  /// Forgets the voxel with dense number `value`. The last voxel takes its number: the owner moves the last element of
  /// each payload array to `value` and pops the back.
  void erase(std::uint32_t value);

  void clear();
  void reserve(std::size_t expected);
  /// The index of these distinct keys, in this order.
  void assign(std::vector<VoxelKey> keys);

 private:
  struct Slot {
    VoxelKey key = kNoVoxel;
    std::uint32_t value = 0;
  };
  // Fibonacci hashing; the xor folds z (bits 42..62) onto the low bits before the multiplication spreads them.
  std::size_t home(VoxelKey key) const { return ((key ^ (key >> 32)) * 0x9E3779B97F4A7C15ull) >> shift_; }
  std::size_t slotOf(VoxelKey key) const;
  void rehash(std::size_t capacity);

  std::vector<Slot> slots_;
  std::vector<VoxelKey> keys_;
  std::size_t mask_ = 0;
  int shift_ = 64;
};

}  // namespace scslam
