#include "scslam/graph/block_symbolic.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <numeric>

namespace scslam::detail {
namespace {

using Index = BlockSymbolic::Index;
using Pairs = std::vector<std::pair<Index, Index>>;
constexpr Index kNone = ~Index{0};

std::vector<Index> minimumDegree(Index size, const Pairs& pairs) {
  std::vector<Eigen::Triplet<double>> triplets;
  triplets.reserve(2 * pairs.size() + size);
  for (Index v = 0; v < size; ++v) triplets.emplace_back(v, v, 1.0);
  for (const auto& [i, j] : pairs) triplets.emplace_back(i, j, 1.0), triplets.emplace_back(j, i, 1.0);
  Eigen::SparseMatrix<double> pattern(size, size);
  pattern.setFromTriplets(triplets.begin(), triplets.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> eliminated;  // position -> variable
  Eigen::AMDOrdering<int>()(pattern, eliminated);
  std::vector<Index> position(size);
  for (Index p = 0; p < size; ++p) position[static_cast<std::size_t>(eliminated.indices()(p))] = p;
  return position;
}

/// Neighbours before each column, by position: the rows of the strict upper triangle.
std::vector<std::vector<Index>> upperNeighbours(const std::vector<Index>& position, const Pairs& pairs) {
  std::vector<std::vector<Index>> result(position.size());
  for (const auto& [i, j] : pairs) {
    const auto [low, high] = std::minmax(position[i], position[j]);
    result[high].push_back(low);
  }
  return result;
}

/// Liu's algorithm with path compression.
std::vector<Index> eliminationTree(const std::vector<std::vector<Index>>& upper) {
  std::vector<Index> parent(upper.size(), kNone), ancestor(upper.size(), kNone);
  for (Index j = 0; j < upper.size(); ++j)
    for (Index i : upper[j])
      while (i != kNone && i < j) {
        const Index next = ancestor[i];
        ancestor[i] = j;
        if (next == kNone) parent[i] = j;
        i = next;
      }
  return parent;
}

/// Position in a postorder of the forest (children in increasing order), without recursion.
std::vector<Index> postorder(const std::vector<Index>& parent) {
  const Index n = static_cast<Index>(parent.size());
  std::vector<Index> child(n, kNone), sibling(n, kNone), stack, result(n);
  for (Index j = n; j-- > 0;)
    if (parent[j] != kNone) sibling[j] = child[parent[j]], child[parent[j]] = j;
  Index next = 0;
  for (Index root = 0; root < n; ++root) {
    if (parent[root] != kNone) continue;
    stack.push_back(root);
    while (!stack.empty()) {
      const Index top = stack.back();
      if (child[top] != kNone) {
        stack.push_back(child[top]);
        child[top] = sibling[child[top]];
      } else {
        result[top] = next++;
        stack.pop_back();
      }
    }
  }
  return result;
}

/// Rows below the diagonal of every column of the factor: the matrix's own and those of the children in the tree.
std::vector<std::vector<Index>> columnStructures(const std::vector<Index>& position, const Pairs& pairs,
                                                 const std::vector<Index>& parent) {
  const Index n = static_cast<Index>(position.size());
  std::vector<std::vector<Index>> structure(n);
  for (const auto& [i, j] : pairs) {
    const auto [low, high] = std::minmax(position[i], position[j]);
    structure[low].push_back(high);
  }
  std::vector<Index> seen(n, kNone), first_child(n, kNone), next_child(n, kNone);
  for (Index j = 0; j < n; ++j) {
    auto& rows = structure[j];
    seen[j] = j;
    for (const Index row : rows) seen[row] = j;
    for (Index c = first_child[j]; c != kNone; c = next_child[c])
      for (const Index row : structure[c])
        if (seen[row] != j) seen[row] = j, rows.push_back(row);
    std::sort(rows.begin(), rows.end());
    if (parent[j] != kNone) next_child[j] = first_child[parent[j]], first_child[parent[j]] = j;
  }
  return structure;
}

/// A child supernode joins its parent's panel when the explicit zeros cost less than the shorter loops gain.
bool worthMerging(double child_width, double child_rows, double width, double rows, double zeros_so_far,
                  double& zeros) {
  const double total_width = child_width + width;
  zeros = zeros_so_far + child_width * (width + rows - child_rows);
  const double stored = total_width * (total_width + 1) / 2 + total_width * rows;
  const double share = zeros / stored;
  return share == 0 || total_width <= 2 || (total_width <= 6 && share < 0.5) || (total_width <= 12 && share < 0.2) ||
         share < 0.05;
}

}  // namespace

BlockSymbolic::BlockSymbolic(Index n, const Pairs& pairs) : size(n) {
  const std::vector<Index> parent = order(pairs);
  auto structure = columnStructures(position, pairs, parent);
  findSupernodes(parent, structure);
  placeEntries(pairs);
}

/// Sets `position`; @return the elimination tree in that order.
std::vector<BlockSymbolic::Index> BlockSymbolic::order(const Pairs& pairs) {
  position = minimumDegree(size, pairs);
  const auto post = postorder(eliminationTree(upperNeighbours(position, pairs)));
  for (Index& p : position) p = post[p];
  return eliminationTree(upperNeighbours(position, pairs));
}

void BlockSymbolic::findSupernodes(const std::vector<Index>& parent, std::vector<std::vector<Index>>& structure) {
  struct Range {
    Index begin, end;
    double zeros;
  };
  std::vector<Range> ranges;
  for (Index j = 0; j < size; ++j) {
    Range current{j, j + 1, 0};
    while (!ranges.empty() && ranges.back().end == current.begin && parent[current.begin - 1] == current.begin) {
      const Range& child = ranges.back();
      const double own_rows = static_cast<double>(structure[current.end - 1].size());
      const double child_rows = static_cast<double>(structure[child.end - 1].size());
      double zeros = 0;
      if (!worthMerging(child.end - child.begin, child_rows, current.end - current.begin, own_rows,
                        child.zeros + current.zeros, zeros))
        break;
      current = {child.begin, current.end, zeros};
      ranges.pop_back();
    }
    ranges.push_back(current);
  }
  supernode_of.resize(size);
  for (const Range& range : ranges) {
    const auto& below = structure[range.end - 1];
    Supernode node{range.begin, range.end, rows.size(), rows.size() + below.size(), 0, 0, panel_blocks};
    rows.insert(rows.end(), below.begin(), below.end());
    std::fill(supernode_of.begin() + range.begin, supernode_of.begin() + range.end,
              static_cast<Index>(supernodes.size()));
    panel_blocks += std::size_t{node.width()} * node.height();
    max_height = std::max(max_height, node.height());
    max_width = std::max(max_width, node.width());
    supernodes.push_back(node);
  }
}

void BlockSymbolic::placeEntries(const Pairs& pairs) {
  struct Placed {
    Index supernode;
    Entry entry;
  };
  std::vector<Placed> placed;
  placed.reserve(size + pairs.size());
  for (Index v = 0; v < size; ++v) {
    const Index s = supernode_of[position[v]];
    const Index local = position[v] - supernodes[s].begin;
    placed.push_back({s, {v, local, local, false}});
  }
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const Index pi = position[pairs[k].first], pj = position[pairs[k].second];
    const auto [column, row] = std::minmax(pi, pj);
    const Index s = supernode_of[column];
    const Supernode& node = supernodes[s];
    Index local_row = row - node.begin;
    if (row >= node.end) {
      const auto first = rows.begin() + static_cast<std::ptrdiff_t>(node.rows_begin);
      const auto last = rows.begin() + static_cast<std::ptrdiff_t>(node.rows_end);
      local_row = node.width() + static_cast<Index>(std::lower_bound(first, last, row) - first);
    }
    placed.push_back({s, {size + static_cast<Index>(k), local_row, column - node.begin, pi < pj}});
  }
  std::stable_sort(placed.begin(), placed.end(),
                   [](const Placed& a, const Placed& b) { return a.supernode < b.supernode; });
  entries.reserve(placed.size());
  std::size_t k = 0;
  for (Index s = 0; s < supernodes.size(); ++s) {
    supernodes[s].entries_begin = k;
    for (; k < placed.size() && placed[k].supernode == s; ++k) entries.push_back(placed[k].entry);
    supernodes[s].entries_end = k;
  }
}

}  // namespace scslam::detail
