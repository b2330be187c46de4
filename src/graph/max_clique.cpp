#include "scslam/graph/max_clique.h"

#include <algorithm>
#include <bit>
#include <numeric>

namespace scslam {
namespace {

using Bits = std::vector<std::uint64_t>;

std::size_t firstBit(const Bits& bits) {
  for (std::size_t w = 0; w < bits.size(); ++w)
    if (bits[w] != 0) return 64 * w + static_cast<std::size_t>(std::countr_zero(bits[w]));
  return bits.size() * 64;
}
void set(Bits& bits, std::size_t i) { bits[i / 64] |= std::uint64_t{1} << (i % 64); }
void clear(Bits& bits, std::size_t i) { bits[i / 64] &= ~(std::uint64_t{1} << (i % 64)); }

/// The search works on the candidates alone, numbered by falling degree.
class Search {
 public:
  Search(const BitGraph& graph, std::vector<std::uint32_t> candidates, std::size_t larger_than, std::size_t budget)
      : best_size_(larger_than), budget_(budget), nodes_(std::move(candidates)) {
    const std::size_t n = nodes_.size();
    std::vector<std::size_t> degree(n, 0), order(n);
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = 0; b < n; ++b) degree[a] += a != b && graph.joined(nodes_[a], nodes_[b]);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return degree[a] > degree[b]; });
    const std::vector<std::uint32_t> given = nodes_;
    for (std::size_t i = 0; i < n; ++i) nodes_[i] = given[order[i]];
    joined_.assign(n, Bits((n + 63) / 64, 0));
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = 0; b < n; ++b)
        if (a != b && graph.joined(nodes_[a], nodes_[b])) set(joined_[a], b);
  }

  CliqueResult run() {
    Bits all((nodes_.size() + 63) / 64, 0);
    for (std::size_t i = 0; i < nodes_.size(); ++i) set(all, i);
    expand(all);
    CliqueResult result;
    for (const std::size_t i : best_) result.nodes.push_back(nodes_[i]);
    std::sort(result.nodes.begin(), result.nodes.end());
    result.exact = budget_ > 0;
    return result;
  }

 private:
  /// Colours classes of nodes that are not joined to each other: a clique takes one node of each at most.
  void colour(const Bits& open, std::vector<std::size_t>& order, std::vector<std::size_t>& colours) const {
    Bits left = open;
    for (std::size_t c = 1;; ++c) {
      Bits free = left;
      std::size_t v = firstBit(free);
      if (v >= nodes_.size()) return;
      for (; v < nodes_.size(); v = firstBit(free)) {
        clear(left, v);
        clear(free, v);
        for (std::size_t w = 0; w < free.size(); ++w) free[w] &= ~joined_[v][w];
        order.push_back(v);
        colours.push_back(c);
      }
    }
  }

  void expand(Bits open) {
    std::vector<std::size_t> order, colours;
    colour(open, order, colours);
    for (std::size_t k = order.size(); k-- > 0;) {
      if (budget_ == 0 || clique_.size() + colours[k] <= best_size_) return;
      --budget_;
      const std::size_t v = order[k];
      clique_.push_back(v);
      Bits next = open;
      for (std::size_t w = 0; w < next.size(); ++w) next[w] &= joined_[v][w];
      if (firstBit(next) < nodes_.size()) {
        expand(std::move(next));
      } else if (clique_.size() > best_size_) {
        best_size_ = clique_.size();
        best_ = clique_;
      }
      clique_.pop_back();
      clear(open, v);
    }
  }

  std::size_t best_size_, budget_;
  std::vector<std::uint32_t> nodes_;
  std::vector<Bits> joined_;
  std::vector<std::size_t> clique_, best_;
};

}  // namespace

std::size_t BitGraph::add(const std::vector<std::uint32_t>& neighbours) {
  const std::size_t v = rows_.size();
  rows_.emplace_back();
  const auto join = [this](std::size_t a, std::size_t b) {
    if (rows_[a].size() <= b / 64) rows_[a].resize(b / 64 + 1, 0);
    set(rows_[a], b);
  };
  for (const std::uint32_t u : neighbours) join(v, u), join(u, v);
  return v;
}

CliqueResult maxClique(const BitGraph& graph, const std::vector<std::uint32_t>& candidates, std::size_t larger_than,
                       std::size_t budget) {
  return Search(graph, candidates, larger_than, budget).run();
}

}  // namespace scslam
