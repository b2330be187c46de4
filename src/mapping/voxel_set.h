// Which voxels of an unbounded map have been seen, in bounded memory.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <unordered_map>

#include <Eigen/Core>

namespace scslam {

/// One bit per voxel in blocks of 8x8x8, grouped into square tiles of about 64 m (whole height). Tiles beyond the
/// budget that were used longest ago wait in files of `spill_folder`, so that a place driven past again is still known:
/// the answers never depend on the budget. Memory: max(budget, one tile); about 100 bytes per block, 0.5 MB for a
/// street tile at 0.1 m.
class VoxelSet {
 public:
  VoxelSet(double voxel_m, std::size_t budget_bytes, std::filesystem::path spill_folder);
  ~VoxelSet();
  VoxelSet(const VoxelSet&) = delete;
  VoxelSet& operator=(const VoxelSet&) = delete;

  /// @return true the first time a point of this voxel comes. @param p_map nearer than reach_m() to the origin.
  bool insert(const Eigen::Vector3d& p_map);
  /// Spills tiles beyond the budget; call it between scans.
  void trim();
  /// Points further than this from the origin cannot be told apart [m].
  double reach_m() const;
  std::size_t bytes() const;
  std::size_t spilled() const { return spilled_; }  ///< tiles written out so far

 private:
  using Block = std::array<std::uint64_t, 8>;  ///< bit x + 8 y of word z
  using TileKey = std::pair<std::int32_t, std::int32_t>;
  struct Tile {
    std::unordered_map<std::uint64_t, Block> blocks;  ///< order never shows: only membership is asked
    std::uint64_t last_use = 0;
    bool on_disk = false;
  };
  Tile& tileAt(TileKey key);
  std::filesystem::path fileOf(TileKey key) const;
  void spill(TileKey key, Tile& tile);
  void load(TileKey key, Tile& tile);

  double voxel_m_;
  std::int64_t tile_blocks_;  ///< blocks along a tile's side
  std::size_t budget_bytes_, blocks_ = 0, spilled_ = 0;
  std::uint64_t clock_ = 0;
  std::filesystem::path spill_folder_;
  std::map<TileKey, Tile> tiles_;
  TileKey newest_key_{};
  Tile* newest_ = nullptr;
};

}  // namespace scslam
