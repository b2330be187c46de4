#include "scslam/graph/block_kernels.h"

#include "scslam/core/simd.h"

namespace scslam::detail {
namespace {

// Four doubles: one AVX2 register or two SSE2 ones; element-wise operations only, so both give the same bits.
using Four = double __attribute__((vector_size(32), aligned(8), may_alias));

}  // namespace

SCSLAM_KERNEL void multiplyTransposed(const double* A, std::size_t lda, const double* B, std::size_t ldb, std::size_t m,
                                      std::size_t n, std::size_t k, double* out, std::size_t ldo) {
  for (std::size_t i = 0; i < m; i += 8) {
    for (std::size_t j = 0; j < n; j += 3) {
      Four c0{}, c1{}, c2{}, d0{}, d1{}, d2{};  // 8 rows x 3 columns of the product
      const double* a = A + i;
      const double* b = B + j;
      for (std::size_t p = 0; p < k; ++p, a += lda, b += ldb) {
        const Four upper = *reinterpret_cast<const Four*>(a);
        const Four lower = *reinterpret_cast<const Four*>(a + 4);
        c0 += upper * b[0];
        d0 += lower * b[0];
        c1 += upper * b[1];
        d1 += lower * b[1];
        c2 += upper * b[2];
        d2 += lower * b[2];
      }
      double* o = out + j * ldo + i;
      *reinterpret_cast<Four*>(o) = c0;
      *reinterpret_cast<Four*>(o + 4) = d0;
      *reinterpret_cast<Four*>(o + ldo) = c1;
      *reinterpret_cast<Four*>(o + ldo + 4) = d1;
      *reinterpret_cast<Four*>(o + 2 * ldo) = c2;
      *reinterpret_cast<Four*>(o + 2 * ldo + 4) = d2;
    }
  }
}

SCSLAM_KERNEL void solveRight(double* X, std::size_t ldx, std::size_t rows, const double* L, std::size_t ldl,
                              std::size_t n) {
  for (std::size_t c = 0; c < n; ++c) {
    double* __restrict x = X + c * ldx;
    for (std::size_t p = 0; p < c; ++p) {
      const double* __restrict y = X + p * ldx;
      const double factor = L[p * ldl + c];
      for (std::size_t r = 0; r < rows; ++r) x[r] -= y[r] * factor;
    }
    const double inverse = 1 / L[c * ldl + c];
    for (std::size_t r = 0; r < rows; ++r) x[r] *= inverse;
  }
}

}  // namespace scslam::detail
