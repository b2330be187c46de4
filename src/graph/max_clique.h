// The largest set of nodes of an undirected graph that are all joined to each other.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace scslam {

/// A symmetric relation between n things, as rows of bits.
class BitGraph {
 public:
  std::size_t size() const { return rows_.size(); }
  /// Adds a node joined to those of `neighbours`. @return its number.
  std::size_t add(const std::vector<std::uint32_t>& neighbours);
  bool joined(std::size_t a, std::size_t b) const { return (word(a, b / 64) >> (b % 64) & 1) != 0; }
  std::size_t words() const { return (size() + 63) / 64; }
  /// Bits of row a; rows are as long as they were when the last neighbour was added: missing words are 0.
  std::uint64_t word(std::size_t a, std::size_t w) const { return w < rows_[a].size() ? rows_[a][w] : 0; }

 private:
  std::vector<std::vector<std::uint64_t>> rows_;
};

struct CliqueResult {
  std::vector<std::uint32_t> nodes;  ///< increasing; empty when none larger than asked for exists (or was found)
  bool exact = true;                 ///< false: the budget ended before the search did
};

/// The largest clique among `candidates` that has more than `larger_than` nodes: branch and bound with greedy colouring
/// (Tomita and Seki 2003) on bit sets. Deterministic; ties go to the first found. @param budget branches at most.
CliqueResult maxClique(const BitGraph& graph, const std::vector<std::uint32_t>& candidates, std::size_t larger_than,
                       std::size_t budget = 100000);

}  // namespace scslam
