// Eight floats at a time: one register with AVX2, two with SSE2; the same operations in the same order, hence the same
// bits. For kernels marked SCSLAM_KERNEL.
#pragma once
#include <cstdint>
#include <cstring>

namespace scslam {

using Float8 = float __attribute__((vector_size(32)));
using Int8 = std::int32_t __attribute__((vector_size(32)));  ///< also the result of a comparison: 0 or -1
constexpr std::size_t kLanes = 8;

inline void load8(Float8& v, const float* p) { std::memcpy(&v, p, sizeof v); }
inline void store8(float* p, const Float8& v) { std::memcpy(p, &v, sizeof v); }

}  // namespace scslam
