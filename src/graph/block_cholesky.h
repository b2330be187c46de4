// Supernodal left-looking Cholesky factorisation of a symmetric positive definite block-sparse matrix.
#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "scslam/graph/block_symbolic.h"

namespace scslam::detail {

/// B x B blocks, B = 3 or 6 (explicitly instantiated). Keeps its memory between factorisations.
template <int B>
class BlockCholesky {
 public:
  explicit BlockCholesky(std::shared_ptr<const BlockSymbolic> symbolic);

  /// Factors H + damping * diag(H). @param blocks B x B column-major, numbered as in BlockSymbolic::Entry; only the
  /// lower triangle of diagonal blocks is read. @return false when the matrix is not (numerically) positive definite.
  bool factor(const std::vector<double>& blocks, double damping);
  /// Solves in place; B numbers per variable.
  void solve(std::vector<double>& x) const;

  using Block = Eigen::Matrix<double, B, B>;
  /// A H^-1 A^T for the A that has J_i at variable i, J_j at variable j and zeros elsewhere: the covariance of what A
  /// measures. Costs a forward substitution along the elimination tree from both, not a solve.
  Block spread(std::uint32_t i, const Block& J_i, std::uint32_t j, const Block& J_j);

 private:
  using Index = BlockSymbolic::Index;
  using Supernode = BlockSymbolic::Supernode;
  void load(const Supernode& node, const std::vector<double>& blocks, double damping);
  void update(const Supernode& target, const Supernode& source, std::size_t first, std::size_t last);
  bool factorPanel(const Supernode& node);
  void forward(const Supernode& node);

  std::shared_ptr<const BlockSymbolic> symbolic_;
  std::vector<double> panels_;
  std::vector<double> product_;      ///< of one update
  std::vector<double> spread_;       ///< right-hand sides of spread(), B to a row, zero between calls
  std::vector<double> diagonal_;     ///< of H by position, what pivots are compared with
  std::vector<Index> row_in_panel_;  ///< of the current target, by position
};

extern template class BlockCholesky<3>;
extern template class BlockCholesky<6>;

}  // namespace scslam::detail
