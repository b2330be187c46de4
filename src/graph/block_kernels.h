// The dense inner loops of the block-sparse Cholesky factorisation: column-major panels, compiled twice (core/simd.h).
#pragma once
#include <cstddef>

namespace scslam::detail {

/// Rows that multiplyTransposed may read and write beyond `m`: allocate that much slack behind a panel.
inline constexpr std::size_t kKernelSlack = 8;

/// out (m x n) = A (m x k) * B^T, B is n x k; all column-major, n a multiple of 3. Rows m … of `out` up to the next
/// multiple of 8 are overwritten with garbage, the same rows of A are read.
void multiplyTransposed(const double* A, std::size_t lda, const double* B, std::size_t ldb, std::size_t m,
                        std::size_t n, std::size_t k, double* out, std::size_t ldo);

/// X := X * L^-T for the `rows` x n matrix X; L is n x n lower triangular, both column-major.
void solveRight(double* X, std::size_t ldx, std::size_t rows, const double* L, std::size_t ldl, std::size_t n);

}  // namespace scslam::detail
