// Fill-reducing order and supernodes of a symmetric block-sparse matrix; made once per graph, used by every
// factorisation of it whatever the block size (3x3 for the chordal start and SE(2), 6x6 for SE(3)).
//
// Method: approximate minimum degree (Amestoy, Davis, Duff 1996; Eigen's implementation) on the graph of variables,
// elimination tree and postorder (Liu 1990), fundamental supernodes relaxed as in CHOLMOD (Chen et al. 2008).
#pragma once
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace scslam::detail {

struct BlockSymbolic {
  using Index = std::uint32_t;

  /// Where one block of the matrix goes in the panel of a supernode. Blocks are numbered: v = diagonal of variable v,
  /// size + s = the off-diagonal block of pairs[s] = (i, j), rows of i, columns of j.
  struct Entry {
    Index block, row, column;
    bool transposed;
  };
  /// Columns [begin, end) of the factor share the rows below; the panel is (end - begin + rows) x (end - begin) blocks.
  struct Supernode {
    Index begin, end;
    std::size_t rows_begin, rows_end;        ///< in `rows`: the block rows below `end`, increasing
    std::size_t entries_begin, entries_end;  ///< in `entries`
    std::size_t panel;                       ///< blocks before this panel
    Index width() const { return end - begin; }
    Index height() const { return width() + static_cast<Index>(rows_end - rows_begin); }
  };

  /// @param pairs distinct, first < second < size.
  BlockSymbolic(Index size, const std::vector<std::pair<Index, Index>>& pairs);

  Index size;
  std::vector<Index> position;  ///< of a variable in the elimination order
  std::vector<Supernode> supernodes;
  std::vector<Index> supernode_of;  ///< by position
  std::vector<Index> rows;
  std::vector<Entry> entries;
  std::size_t panel_blocks = 0;  ///< of all panels
  Index max_height = 0, max_width = 0;

 private:
  std::vector<Index> order(const std::vector<std::pair<Index, Index>>& pairs);
  void findSupernodes(const std::vector<Index>& parent, std::vector<std::vector<Index>>& structure);
  void placeEntries(const std::vector<std::pair<Index, Index>>& pairs);
};

}  // namespace scslam::detail
