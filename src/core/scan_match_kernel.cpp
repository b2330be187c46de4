// The hot loop: points in blocks, structure of arrays; look-ups are scalar, everything around them is 8 wide.
#include <algorithm>
#include <cmath>

#include "scslam/core/scan_match.h"
#include "scslam/core/simd.h"

namespace scslam {
namespace {

constexpr std::size_t kBlock = 256;   // points in flight; a block's arrays stay in L1
constexpr std::size_t kChunk = 1024;  // points of a thread's unit of work

// Eight floats: one register with AVX2, two with SSE2; the same operations in the same order, hence the same bits.
using Float8 = float __attribute__((vector_size(32)));
constexpr std::size_t kLanes = 8;
constexpr std::size_t kTerms = 27;  // 21 of H (upper triangle, row by row), 6 of g

struct Block {
  alignas(32) float x[kBlock], y[kBlock], z[kBlock];  // source point, frame scan
  alignas(32) float px[kBlock], py[kBlock], pz[kBlock];
  VoxelKey key[kBlock];
  alignas(32) float nx[kBlock], ny[kBlock], nz[kBlock];  // normal of the plane found, frame map
  alignas(32) float r[kBlock], variance[kBlock];         // residual [m]; variance < 0: no plane
  bool rough[kBlock];                                    // any scan fits there
};

struct Sums {
  Float8 terms[kTerms] = {};
};

struct KeyParams {
  float R[9], t[3], inverse_size;
  std::int32_t anchor[3];
};

/// Points placed in the map (relative to the frame's anchor) and the voxels they fall into.
SCSLAM_KERNEL
void placeBlock(Block& b, std::size_t n, const KeyParams& f) {
  for (std::size_t i = 0; i < n; ++i) {
    b.px[i] = f.R[0] * b.x[i] + f.R[1] * b.y[i] + f.R[2] * b.z[i] + f.t[0];
    b.py[i] = f.R[3] * b.x[i] + f.R[4] * b.y[i] + f.R[5] * b.z[i] + f.t[1];
    b.pz[i] = f.R[6] * b.x[i] + f.R[7] * b.y[i] + f.R[8] * b.z[i] + f.t[2];
    b.key[i] = packVoxel(floorToInt(b.px[i] * f.inverse_size) + f.anchor[0],
                         floorToInt(b.py[i] * f.inverse_size) + f.anchor[1],
                         floorToInt(b.pz[i] * f.inverse_size) + f.anchor[2]);
  }
}

KeyParams keyParams(const VoxelFrame& frame, double voxel_m) {
  KeyParams f;
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) f.R[3 * row + col] = frame.R(row, col);
    f.t[row] = frame.t[row];
    f.anchor[row] = frame.anchor[row];
  }
  f.inverse_size = static_cast<float>(1.0 / voxel_m);
  return f;
}

/// Weighted normal equations of a block. Jacobian of r by the right perturbation: m = R^T n, p x m.
SCSLAM_KERNEL
void accumulateBlock(const Block& b, std::size_t n, const KeyParams& f, float width2, float sigma2, Sums& sums) {
  const auto load = [](const float* p) -> const Float8& { return *reinterpret_cast<const Float8*>(p); };
  for (std::size_t i = 0; i < n; i += kLanes) {
    const Float8 nx = load(b.nx + i), ny = load(b.ny + i), nz = load(b.nz + i), r = load(b.r + i);
    const Float8 x = load(b.x + i), y = load(b.y + i), z = load(b.z + i), variance = load(b.variance + i);
    Float8 J[6];
    J[0] = f.R[0] * nx + f.R[3] * ny + f.R[6] * nz;
    J[1] = f.R[1] * nx + f.R[4] * ny + f.R[7] * nz;
    J[2] = f.R[2] * nx + f.R[5] * ny + f.R[8] * nz;
    J[3] = y * J[2] - z * J[1];
    J[4] = z * J[0] - x * J[2];
    J[5] = x * J[1] - y * J[0];
    const Float8 s = width2 / (width2 + r * r);
    const Float8 w = variance >= 0.0f ? s * s / (variance + sigma2) : Float8{};
    std::size_t term = 0;
    for (int row = 0; row < 6; ++row) {
      const Float8 wJ = w * J[row];
      for (int col = row; col < 6; ++col) sums.terms[term++] += wJ * J[col];
      sums.terms[21 + row] += wJ * r;
    }
  }
}

/// Finds the planes of the points in `pending` at one level; what stays without a plane stays in `pending`.
void lookUp(const VoxelSurface& surface, Block& b, std::uint16_t* pending, std::size_t& n) {
  const auto size = static_cast<float>(surface.voxelSize()),
             inverse_size = static_cast<float>(1.0 / surface.voxelSize());
  std::size_t left = 0;
  for (std::size_t k = 0; k < n; ++k) surface.prefetch(b.key[pending[k]]);
  for (std::size_t k = 0; k < n; ++k) {
    const std::uint16_t i = pending[k];
    const Surfel* surfel = surface.find(b.key[i]);
    if (surfel == nullptr) {
      pending[left++] = i;
      continue;
    }
    const float dx = b.px[i] - static_cast<float>(floorToInt(b.px[i] * inverse_size)) * size - surfel->mx;
    const float dy = b.py[i] - static_cast<float>(floorToInt(b.py[i] * inverse_size)) * size - surfel->my;
    const float dz = b.pz[i] - static_cast<float>(floorToInt(b.pz[i] * inverse_size)) * size - surfel->mz;
    b.nx[i] = surfel->nx, b.ny[i] = surfel->ny, b.nz[i] = surfel->nz;
    b.r[i] = surfel->nx * dx + surfel->ny * dy + surfel->nz * dz;
    b.variance[i] = surfel->variance;
    b.rough[i] = surfel->rough();
  }
  n = left;
}

void countBlock(Block& b, std::size_t n, const MatchKernel& kernel, MatchSystem& system) {
  const auto gate = static_cast<float>(kernel.gate_m), inlier = static_cast<float>(kernel.inlier_m);
  const float to_bin = static_cast<float>(MatchSystem::kBins) / gate, inverse_inlier2 = 1.0f / (inlier * inlier);
  for (std::size_t i = 0; i < n; ++i) {
    const float distance = std::abs(b.r[i]);
    if (b.variance[i] < 0 || !(distance < gate)) {
      b.variance[i] = -1;
      continue;
    }
    ++system.histogram[std::min(static_cast<std::size_t>(distance * to_bin), MatchSystem::kBins - 1)];
    ++system.matched;
    system.clear_matched += b.rough[i] ? 0 : 1;
    if (distance > inlier) continue;
    const float r2 = distance * distance;
    ++system.inliers;
    system.clear_inliers += b.rough[i] ? 0 : 1;
    system.inlier_r2 += static_cast<double>(r2);
    system.score += static_cast<double>(1.0f - r2 * inverse_inlier2);
  }
}

void addSums(const Sums& sums, MatchSystem& system) {
  std::size_t term = 0;
  const auto total = [&sums](std::size_t k) {
    double sum = 0;
    for (std::size_t lane = 0; lane < kLanes; ++lane) sum += static_cast<double>(sums.terms[k][lane]);
    return sum;
  };
  for (int row = 0; row < 6; ++row) {
    for (int col = row; col < 6; ++col) system.H(row, col) += total(term++);
    system.g(row) += total(21 + static_cast<std::size_t>(row));
  }
}

class Linearisation {
 public:
  Linearisation(const SurfacePyramid& map, LevelRange levels, const Cloud& source, const Pose& T_map_scan,
                const MatchKernel& kernel)
      : map_(map), levels_(levels), source_(source), kernel_(kernel) {
    for (int l = levels.finest; l <= levels.coarsest; ++l) {
      params_.push_back(keyParams(VoxelFrame(T_map_scan, map.level(l).voxelSize()), map.level(l).voxelSize()));
    }
  }

  double score() const {
    MatchSystem system;
    Block block;
    for (std::size_t begin = 0; begin < source_.size(); begin += kBlock) {
      const std::size_t n = std::min(kBlock, source_.size() - begin);
      load(begin, n, n, block);
      match(block, n);
      countBlock(block, n, kernel_, system);
    }
    return source_.empty() ? 0.0 : system.score / static_cast<double>(source_.size());
  }

  MatchSystem chunk(std::size_t begin, std::size_t end) const {
    MatchSystem system;
    Sums sums;
    Block block;
    for (; begin < end; begin += kBlock) {
      const std::size_t n = std::min(kBlock, end - begin), padded = (n + kLanes - 1) / kLanes * kLanes;
      load(begin, n, padded, block);
      match(block, n);
      countBlock(block, n, kernel_, system);
      accumulateBlock(block, padded, params_.front(), static_cast<float>(kernel_.width_m * kernel_.width_m),
                      static_cast<float>(kernel_.sigma_m * kernel_.sigma_m), sums);
    }
    addSums(sums, system);
    return system;
  }

 private:
  void load(std::size_t begin, std::size_t n, std::size_t padded, Block& block) const {
    std::copy_n(&source_.x[begin], n, block.x);
    std::copy_n(&source_.y[begin], n, block.y);
    std::copy_n(&source_.z[begin], n, block.z);
    for (std::size_t i = n; i < padded; ++i) block.x[i] = block.y[i] = block.z[i] = 0;
    for (std::size_t i = 0; i < padded; ++i) {
      block.nx[i] = block.ny[i] = block.nz[i] = block.r[i] = 0;
      block.variance[i] = -1;
    }
  }

  void match(Block& block, std::size_t n) const {
    std::uint16_t pending[kBlock];
    for (std::size_t i = 0; i < n; ++i) pending[i] = static_cast<std::uint16_t>(i);
    std::size_t left = n;
    for (int l = levels_.finest; l <= levels_.coarsest && left > 0; ++l) {
      const auto k = static_cast<std::size_t>(l - levels_.finest);
      placeBlock(block, n, params_[k]);
      lookUp(map_.level(l), block, pending, left);
    }
  }

  const SurfacePyramid& map_;
  LevelRange levels_;
  const Cloud& source_;
  MatchKernel kernel_;
  std::vector<KeyParams> params_;
};

}  // namespace

void addSystem(const MatchSystem& part, MatchSystem& total) {
  total.H += part.H;
  total.g += part.g;
  total.matched += part.matched;
  total.inliers += part.inliers;
  total.clear_matched += part.clear_matched;
  total.clear_inliers += part.clear_inliers;
  total.inlier_r2 += part.inlier_r2;
  total.score += part.score;
  for (std::size_t i = 0; i < MatchSystem::kBins; ++i) total.histogram[i] += part.histogram[i];
}

MatchSystem linearise(const SurfacePyramid& map, LevelRange levels, const Cloud& source, const Pose& T_map_scan,
                      const MatchKernel& kernel, ThreadPool& threads) {
  const Linearisation linearisation(map, levels, source, T_map_scan, kernel);
  std::vector<MatchSystem> parts(chunkCount(source.size(), kChunk));
  threads.forEachChunk(source.size(), kChunk, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
    parts[chunk] = linearisation.chunk(begin, end);
  });
  MatchSystem total;
  total.points = static_cast<std::uint32_t>(source.size());
  for (const MatchSystem& part : parts) addSystem(part, total);
  total.H.triangularView<Eigen::StrictlyLower>() = total.H.transpose();
  return total;
}

double matchScore(const SurfacePyramid& map, int level, const Cloud& source, const Pose& T_map_scan, double inlier_m) {
  MatchKernel kernel;
  kernel.gate_m = map.level(level).voxelSize();
  kernel.inlier_m = inlier_m;
  return Linearisation(map, {level, level}, source, T_map_scan, kernel).score();
}

}  // namespace scslam
