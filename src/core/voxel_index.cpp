#include "scslam/core/voxel_index.h"

#include <algorithm>
#include <bit>

namespace scslam {

std::size_t VoxelIndex::slotOf(VoxelKey key) const {
  std::size_t slot = home(key);
  while (slots_[slot].key != key) slot = (slot + 1) & mask_;
  return slot;
}

void VoxelIndex::erase(std::uint32_t value) {
  std::size_t hole = slotOf(keys_[value]);
  if (value + 1 != keys_.size()) {
    slots_[slotOf(keys_.back())].value = value;
    keys_[value] = keys_.back();
  }
  keys_.pop_back();
  // Close the gap: an element further down the run may move up unless that would put it before its home.
  for (std::size_t slot = (hole + 1) & mask_; slots_[slot].key != kNoVoxel; slot = (slot + 1) & mask_) {
    const std::size_t from_home = (slot - home(slots_[slot].key)) & mask_;
    if (from_home >= ((slot - hole) & mask_)) {
      slots_[hole] = slots_[slot];
      hole = slot;
    }
  }
  slots_[hole].key = kNoVoxel;
}

void VoxelIndex::clear() {
  keys_.clear();
  std::fill(slots_.begin(), slots_.end(), Slot{});
}

void VoxelIndex::reserve(std::size_t expected) {
  const std::size_t capacity = std::bit_ceil(std::max<std::size_t>(2 * expected + 2, 64));
  if (capacity > slots_.size()) rehash(capacity);
}

void VoxelIndex::assign(std::vector<VoxelKey> keys) {
  keys_ = std::move(keys);
  rehash(std::bit_ceil(std::max<std::size_t>(2 * keys_.size() + 2, 64)));
}

void VoxelIndex::rehash(std::size_t capacity) {
  slots_.assign(capacity, Slot{});
  mask_ = capacity - 1;
  shift_ = 64 - std::countr_zero(capacity);
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    std::size_t slot = home(keys_[i]);
    while (slots_[slot].key != kNoVoxel) slot = (slot + 1) & mask_;
    slots_[slot] = {keys_[i], static_cast<std::uint32_t>(i)};
  }
}

}  // namespace scslam
