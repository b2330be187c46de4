// Shared by the props_*.cpp.
#pragma once
#include "scslam/core/counter_random.h"

namespace scslam::sim {

/// A sequence of its own, started by two numbers of `random`.
inline RandomSequence fork(RandomSequence& random) {
  const auto high = static_cast<std::uint64_t>(random.below(0x7FFFFFFF));
  const auto low = static_cast<std::uint64_t>(random.below(0x7FFFFFFF));
  return RandomSequence(CounterRandom(high << 32 | low, RandomStream::kWorld));
}

}  // namespace scslam::sim
