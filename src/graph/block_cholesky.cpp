#include "scslam/graph/block_cholesky.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scslam/graph/block_kernels.h"

namespace scslam::detail {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};
/// A pivot this much smaller than its diagonal element is rounding error: the direction is not fixed by the factors.
constexpr double kPivotTolerance = 1e-14;

}  // namespace

template <int B>
BlockCholesky<B>::BlockCholesky(std::shared_ptr<const BlockSymbolic> symbolic)
    : symbolic_(std::move(symbolic)),
      panels_(symbolic_->panel_blocks * B * B + kKernelSlack),
      diagonal_(std::size_t{symbolic_->size} * B),
      row_in_panel_(symbolic_->size) {
  product_.resize((std::size_t{symbolic_->max_height} * B + 2 * kKernelSlack) * symbolic_->max_width * B);
}

template <int B>
bool BlockCholesky<B>::factor(const std::vector<double>& blocks, double damping) {
  const auto& nodes = symbolic_->supernodes;
  const auto& rows = symbolic_->rows;
  // pending[s]: finished supernodes whose next row lies in s, chained by next; reached[d]: that row.
  std::vector<Index> pending(nodes.size(), kNone), next(nodes.size(), kNone);
  std::vector<std::size_t> reached(nodes.size());
  const auto enqueue = [&](Index d) {
    if (reached[d] == nodes[d].rows_end) return;
    const Index target = symbolic_->supernode_of[rows[reached[d]]];
    next[d] = pending[target];
    pending[target] = d;
  };
  for (Index s = 0; s < nodes.size(); ++s) {
    const Supernode& node = nodes[s];
    load(node, blocks, damping);
    for (Index p = node.begin; p < node.end; ++p) row_in_panel_[p] = p - node.begin;
    for (std::size_t k = node.rows_begin; k < node.rows_end; ++k)
      row_in_panel_[rows[k]] = node.width() + static_cast<Index>(k - node.rows_begin);
    for (Index d = pending[s]; d != kNone;) {
      const Index following = next[d];
      std::size_t last = reached[d];
      while (last < nodes[d].rows_end && rows[last] < node.end) ++last;
      update(node, nodes[d], reached[d], last);
      reached[d] = last;
      enqueue(d);
      d = following;
    }
    if (!factorPanel(node)) return false;
    reached[s] = node.rows_begin;
    enqueue(s);
  }
  return true;
}

template <int B>
void BlockCholesky<B>::load(const Supernode& node, const std::vector<double>& blocks, double damping) {
  double* panel = panels_.data() + node.panel * B * B;
  const std::size_t ld = std::size_t{node.height()} * B;
  std::fill_n(panel, ld * node.width() * B, 0.0);
  for (std::size_t k = node.entries_begin; k < node.entries_end; ++k) {
    const auto& entry = symbolic_->entries[k];
    const double* block = blocks.data() + std::size_t{entry.block} * B * B;
    double* to = panel + std::size_t{entry.column} * B * ld + std::size_t{entry.row} * B;
    for (int c = 0; c < B; ++c)
      for (int r = 0; r < B; ++r)
        to[static_cast<std::size_t>(c) * ld + static_cast<std::size_t>(r)] =
            entry.transposed ? block[r * B + c] : block[c * B + r];
    if (entry.block >= symbolic_->size) continue;
    double* diagonal = diagonal_.data() + std::size_t{node.begin + entry.row} * B;
    for (std::size_t c = 0; c < B; ++c) {
      to[c * ld + c] *= 1 + damping;
      diagonal[c] = to[c * ld + c];
    }
  }
}

/// target -= source's rows [first, …) times its rows [first, last), which lie in the target's columns.
template <int B>
void BlockCholesky<B>::update(const Supernode& target, const Supernode& source, std::size_t first, std::size_t last) {
  const std::size_t source_ld = std::size_t{source.height()} * B;
  const double* from =
      panels_.data() + source.panel * B * B + (source.width() + (first - source.rows_begin)) * std::size_t{B};
  const std::size_t m = (source.rows_end - first) * B, n = (last - first) * B;
  const std::size_t ldo = (m + kKernelSlack - 1) / kKernelSlack * kKernelSlack;
  multiplyTransposed(from, source_ld, from, source_ld, m, n, std::size_t{source.width()} * B, product_.data(), ldo);
  double* panel = panels_.data() + target.panel * B * B;
  const std::size_t ld = std::size_t{target.height()} * B;
  const Index* rows = symbolic_->rows.data();
  for (std::size_t c = first; c < last; ++c)
    for (std::size_t k = 0; k < B; ++k) {
      double* column = panel + (std::size_t{rows[c] - target.begin} * B + k) * ld;
      const double* product = product_.data() + ((c - first) * B + k) * ldo;
      for (std::size_t r = c; r < source.rows_end; ++r) {
        double* to = column + std::size_t{row_in_panel_[rows[r]]} * B;
        const double* value = product + (r - first) * B;
        for (std::size_t q = 0; q < B; ++q) to[q] -= value[q];
      }
    }
}

template <int B>
bool BlockCholesky<B>::factorPanel(const Supernode& node) {
  double* panel = panels_.data() + node.panel * B * B;
  const std::size_t ld = std::size_t{node.height()} * B;
  for (std::size_t j = 0; j < node.width(); ++j) {
    const std::size_t top = j * B, m = ld - top;
    double* columns = panel + top * ld + top;
    if (j > 0) {
      const std::size_t ldo = (m + kKernelSlack - 1) / kKernelSlack * kKernelSlack;
      multiplyTransposed(panel + top, ld, panel + top, ld, m, B, top, product_.data(), ldo);
      for (std::size_t c = 0; c < B; ++c)
        for (std::size_t r = 0; r < m; ++r) columns[c * ld + r] -= product_[c * ldo + r];
    }
    for (std::size_t c = 0; c < B; ++c) {
      double pivot = columns[c * ld + c];
      for (std::size_t p = 0; p < c; ++p) pivot -= columns[p * ld + c] * columns[p * ld + c];
      if (!(pivot > kPivotTolerance * diagonal_[(node.begin + j) * B + c]) || !std::isfinite(pivot)) return false;
      columns[c * ld + c] = std::sqrt(pivot);
      for (std::size_t r = c + 1; r < B; ++r) {
        double value = columns[c * ld + r];
        for (std::size_t p = 0; p < c; ++p) value -= columns[p * ld + r] * columns[p * ld + c];
        columns[c * ld + r] = value / columns[c * ld + c];
      }
    }
    solveRight(columns + B, ld, m - B, columns, ld, B);
  }
  return true;
}

template <int B>
void BlockCholesky<B>::solve(std::vector<double>& x) const {
  std::vector<double> y(x.size());
  for (std::size_t v = 0; v < symbolic_->size; ++v)
    std::copy_n(x.begin() + static_cast<std::ptrdiff_t>(v * B), B,
                y.begin() + static_cast<std::ptrdiff_t>(std::size_t{symbolic_->position[v]} * B));
  for (const Supernode& node : symbolic_->supernodes) {  // L z = b
    const double* panel = panels_.data() + node.panel * B * B;
    const std::size_t ld = std::size_t{node.height()} * B, width = std::size_t{node.width()} * B;
    double* own = y.data() + std::size_t{node.begin} * B;
    for (std::size_t c = 0; c < width; ++c) {
      const double* column = panel + c * ld;
      own[c] /= column[c];
      for (std::size_t r = c + 1; r < width; ++r) own[r] -= column[r] * own[c];
      for (std::size_t k = node.rows_begin, r = width; k < node.rows_end; ++k)
        for (std::size_t q = 0; q < B; ++q, ++r) y[std::size_t{symbolic_->rows[k]} * B + q] -= column[r] * own[c];
    }
  }
  for (auto node = symbolic_->supernodes.rbegin(); node != symbolic_->supernodes.rend(); ++node) {  // L^T x = z
    const double* panel = panels_.data() + node->panel * B * B;
    const std::size_t ld = std::size_t{node->height()} * B, width = std::size_t{node->width()} * B;
    double* own = y.data() + std::size_t{node->begin} * B;
    for (std::size_t c = width; c-- > 0;) {
      const double* column = panel + c * ld;
      double sum = own[c];
      for (std::size_t r = c + 1; r < width; ++r) sum -= column[r] * own[r];
      for (std::size_t k = node->rows_begin, r = width; k < node->rows_end; ++k)
        for (std::size_t q = 0; q < B; ++q, ++r) sum -= column[r] * y[std::size_t{symbolic_->rows[k]} * B + q];
      own[c] = sum / column[c];
    }
  }
  for (std::size_t v = 0; v < symbolic_->size; ++v)
    std::copy_n(y.begin() + static_cast<std::ptrdiff_t>(std::size_t{symbolic_->position[v]} * B), B,
                x.begin() + static_cast<std::ptrdiff_t>(v * B));
}

/// L z = b for the rows of one supernode, on spread_.
template <int B>
void BlockCholesky<B>::forward(const Supernode& node) {
  using Row = Eigen::Matrix<double, 1, B>;
  const double* panel = panels_.data() + node.panel * B * B;
  const std::size_t ld = std::size_t{node.height()} * B, width = std::size_t{node.width()} * B;
  const auto row = [&](std::size_t r) { return Eigen::Map<Row>(spread_.data() + r * B); };
  for (std::size_t c = 0; c < width; ++c) {
    const double* column = panel + c * ld;
    const std::size_t own = std::size_t{node.begin} * B;
    row(own + c) /= column[c];
    const Row z = row(own + c);
    for (std::size_t r = c + 1; r < width; ++r) row(own + r) -= column[r] * z;
    for (std::size_t k = node.rows_begin, r = width; k < node.rows_end; ++k)
      for (std::size_t q = 0; q < B; ++q, ++r) row(std::size_t{symbolic_->rows[k]} * B + q) -= column[r] * z;
  }
}

template <int B>
typename BlockCholesky<B>::Block BlockCholesky<B>::spread(std::uint32_t i, const Block& J_i, std::uint32_t j,
                                                          const Block& J_j) {
  spread_.resize(std::size_t{symbolic_->size} * B * B, 0.0);
  const auto nodeOf = [&](Index v) { return symbolic_->supernode_of[symbolic_->position[v]]; };
  const auto rowsOf = [&](Index p, Index count) {
    return Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, B, Eigen::RowMajor>>(
        spread_.data() + std::size_t{p} * B * B, static_cast<Eigen::Index>(count) * B, B);
  };
  std::vector<Index> open;
  for (const auto& [v, J] : {std::pair{i, &J_i}, std::pair{j, &J_j}}) {
    if (v >= symbolic_->size) continue;  // a node that does not move
    rowsOf(symbolic_->position[v], 1) += J->transpose();
    open.push_back(nodeOf(v));
  }
  Block result = Block::Zero();
  while (!open.empty()) {  // from both leaves to the root, lower columns first
    const auto lowest = std::min_element(open.begin(), open.end());
    const Index s = *lowest;
    open.erase(lowest);
    if (std::find(open.begin(), open.end(), s) != open.end()) continue;  // where both paths have met
    const Supernode& node = symbolic_->supernodes[s];
    forward(node);
    auto z = rowsOf(node.begin, node.width());
    result.noalias() += z.transpose() * z;
    z.setZero();
    if (node.rows_end > node.rows_begin) open.push_back(symbolic_->supernode_of[symbolic_->rows[node.rows_begin]]);
  }
  return result;
}

template class BlockCholesky<3>;
template class BlockCholesky<6>;

}  // namespace scslam::detail
