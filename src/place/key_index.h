// Nearest neighbours among the retrieval keys of all places so far.
//
// A linear scan over a structure of arrays: with 20 dimensions it beats a k-d tree at every size up to 50 000 places
// (place_bench shows both), it needs no building and growing it never moves what is there.
#pragma once
#include <cstddef>
#include <memory>
#include <vector>

namespace scslam {

class KeyIndex {
 public:
  struct Neighbour {
    float distance2;
    std::size_t id;
    friend auto operator<=>(const Neighbour&, const Neighbour&) = default;
  };

  explicit KeyIndex(std::size_t dimensions) : dimensions_(dimensions) {}

  /// Adds the key of the next id (0, 1, …).
  void add(const float* key);
  std::size_t size() const { return size_; }
  /// The `count` nearest among ids 0 .. n-1, nearest first, ties by id. Replaces the contents of `found`.
  void nearest(const float* key, std::size_t n, std::size_t count, std::vector<Neighbour>& found) const;

 private:
  static constexpr std::size_t kBlock = 1024;  ///< keys; one array per dimension
  std::size_t dimensions_, size_ = 0;
  std::vector<std::unique_ptr<float[]>> blocks_;
};

}  // namespace scslam
