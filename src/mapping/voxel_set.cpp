#include "scslam/mapping/voxel_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "scslam/core/bytes.h"
#include "scslam/core/file.h"

namespace scslam {
namespace {

constexpr double kTileSide = 64;             // [m]
constexpr std::size_t kBytesPerBlock = 104;  // 64 of bits, the rest is the hash table
constexpr int kKeyBits = 21;
constexpr std::int64_t kKeyLimit = std::int64_t{1} << (kKeyBits - 1);

std::uint64_t keyOf(std::int64_t x, std::int64_t y, std::int64_t z) {
  const auto bits = [](std::int64_t v) { return static_cast<std::uint64_t>(v + kKeyLimit) & ((1u << kKeyBits) - 1); };
  return bits(x) | bits(y) << kKeyBits | bits(z) << (2 * kKeyBits);
}

std::int64_t floorDivided(std::int64_t value, std::int64_t by) { return (value - (value < 0 ? by - 1 : 0)) / by; }

}  // namespace

VoxelSet::VoxelSet(double voxel_m, std::size_t budget_bytes, std::filesystem::path spill_folder)
    : voxel_m_(voxel_m),
      tile_blocks_(std::max<std::int64_t>(1, std::llround(kTileSide / (8 * voxel_m)))),
      budget_bytes_(budget_bytes),
      spill_folder_(std::move(spill_folder)) {}

VoxelSet::~VoxelSet() {
  std::error_code ignored;
  for (const auto& [key, tile] : tiles_)
    if (tile.on_disk) std::filesystem::remove(fileOf(key), ignored);
}

double VoxelSet::reach_m() const { return static_cast<double>(kKeyLimit) * 8 * voxel_m_ * 0.999; }
std::size_t VoxelSet::bytes() const { return blocks_ * kBytesPerBlock; }

bool VoxelSet::insert(const Eigen::Vector3d& p_map) {
  const auto voxel = [this](double v) { return static_cast<std::int64_t>(std::floor(v / voxel_m_)); };
  const std::int64_t x = voxel(p_map.x()), y = voxel(p_map.y()), z = voxel(p_map.z());
  const std::int64_t bx = x >> 3, by = y >> 3, bz = z >> 3;
  Tile& tile = tileAt({static_cast<std::int32_t>(floorDivided(bx, tile_blocks_)),
                       static_cast<std::int32_t>(floorDivided(by, tile_blocks_))});
  const auto [block, is_new] = tile.blocks.try_emplace(keyOf(bx, by, bz), Block{});
  if (is_new) ++blocks_;
  std::uint64_t& word = block->second[static_cast<std::size_t>(z & 7)];
  const std::uint64_t bit = std::uint64_t{1} << ((x & 7) + 8 * (y & 7));
  if ((word & bit) != 0) return false;
  word |= bit;
  return true;
}

VoxelSet::Tile& VoxelSet::tileAt(TileKey key) {
  if (newest_ != nullptr && newest_key_ == key) return *newest_;
  Tile& tile = tiles_[key];
  if (tile.on_disk) load(key, tile);
  tile.last_use = ++clock_;
  newest_key_ = key;
  newest_ = &tile;
  return tile;
}

void VoxelSet::trim() {
  if (bytes() <= budget_bytes_) return;
  std::vector<std::pair<std::uint64_t, TileKey>> by_age;
  for (const auto& [key, tile] : tiles_)
    if (!tile.on_disk) by_age.push_back({tile.last_use, key});
  std::sort(by_age.begin(), by_age.end());
  newest_ = nullptr;
  for (std::size_t i = 0; i + 1 < by_age.size() && bytes() > budget_bytes_; ++i)
    spill(by_age[i].second, tiles_[by_age[i].second]);
}

std::filesystem::path VoxelSet::fileOf(TileKey key) const {
  return spill_folder_ / fmt::format("voxels_{}_{}.tmp", key.first, key.second);
}

void VoxelSet::spill(TileKey key, Tile& tile) {
  ByteWriter out;
  for (const auto& [block_key, block] : tile.blocks) {
    out.put(block_key);
    for (const std::uint64_t word : block) out.put(word);
  }
  AppendFile(fileOf(key), 0).append(out.bytes());
  blocks_ -= tile.blocks.size();
  ++spilled_;
  tile.blocks = {};
  tile.on_disk = true;
}

void VoxelSet::load(TileKey key, Tile& tile) {
  const std::string bytes = readFile(fileOf(key));
  ByteReader in(bytes);
  while (!in.done()) {
    Block& block = tile.blocks[in.get<std::uint64_t>()];
    for (std::uint64_t& word : block) in.get(word);
  }
  blocks_ += tile.blocks.size();
  tile.on_disk = false;
  std::filesystem::remove(fileOf(key));
}

}  // namespace scslam
