// Supernodal left-looking Cholesky factorisation of a symmetric positive definite block-sparse matrix.
#pragma once
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

 private:
  using Index = BlockSymbolic::Index;
  using Supernode = BlockSymbolic::Supernode;
  void load(const Supernode& node, const std::vector<double>& blocks, double damping);
  void update(const Supernode& target, const Supernode& source, std::size_t first, std::size_t last);
  bool factorPanel(const Supernode& node);

  std::shared_ptr<const BlockSymbolic> symbolic_;
  std::vector<double> panels_;
  std::vector<double> product_;      ///< of one update
  std::vector<double> diagonal_;     ///< of H by position, what pivots are compared with
  std::vector<Index> row_in_panel_;  ///< of the current target, by position
};

extern template class BlockCholesky<3>;
extern template class BlockCholesky<6>;

}  // namespace scslam::detail
