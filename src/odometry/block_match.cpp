#include "scslam/odometry/block_match.h"

#include "scslam/core/simd.h"

namespace scslam {
namespace {

// Eight floats: one register with AVX2, two with SSE2; the same operations in the same order, hence the same bits.
using Float8 = float __attribute__((vector_size(32)));
constexpr std::size_t kTerms = 27;  // 21 of H (upper triangle, row by row), 6 of g

SCSLAM_KERNEL
void sumTerms(const TermBlock& b, std::size_t n, float (&sums)[kTerms][TermBlock::kLanes]) {
  const auto load = [](const float* p) -> const Float8& { return *reinterpret_cast<const Float8*>(p); };
  Float8 total[kTerms] = {};
  for (std::size_t i = 0; i < n; i += TermBlock::kLanes) {
    const Float8 p[3] = {load(b.x + i), load(b.y + i), load(b.z + i)};
    const Float8 d[3] = {load(b.dx + i), load(b.dy + i), load(b.dz + i)};
    Float8 M[6];
    for (int k = 0; k < 6; ++k) M[k] = load(b.M[k] + i);
    const Float8 rows[3][3] = {{M[0], M[1], M[2]}, {M[1], M[3], M[4]}, {M[2], M[4], M[5]}};
    Float8 B[3][3];  // -M [p]x
    for (int row = 0; row < 3; ++row) {
      B[row][0] = p[1] * rows[row][2] - p[2] * rows[row][1];
      B[row][1] = p[2] * rows[row][0] - p[0] * rows[row][2];
      B[row][2] = p[0] * rows[row][1] - p[1] * rows[row][0];
    }
    std::size_t term = 0;
    for (int row = 0; row < 3; ++row) {
      for (int col = row; col < 3; ++col) total[term++] += rows[row][col];
      for (int col = 0; col < 3; ++col) total[term++] += B[row][col];
    }
    for (int row = 0; row < 3; ++row) {  // [p]x B
      const int a = (row + 1) % 3, c = (row + 2) % 3;
      for (int col = row; col < 3; ++col) total[term++] += p[a] * B[c][col] - p[c] * B[a][col];
    }
    Float8 v[3];
    for (int row = 0; row < 3; ++row) v[row] = rows[row][0] * d[0] + rows[row][1] * d[1] + rows[row][2] * d[2];
    for (const Float8& part : v) total[term++] += part;
    for (int row = 0; row < 3; ++row) {
      const int a = (row + 1) % 3, c = (row + 2) % 3;
      total[term++] += p[a] * v[c] - p[c] * v[a];
    }
  }
  for (std::size_t term = 0; term < kTerms; ++term)
    for (std::size_t lane = 0; lane < TermBlock::kLanes; ++lane) sums[term][lane] = total[term][lane];
}

}  // namespace

void addTerms(TermBlock& block, std::size_t n, MatchSystem& system) {
  if (n == 0) return;
  const std::size_t padded = (n + TermBlock::kLanes - 1) / TermBlock::kLanes * TermBlock::kLanes;
  for (std::size_t i = n; i < padded; ++i) {
    block.x[i] = block.y[i] = block.z[i] = block.dx[i] = block.dy[i] = block.dz[i] = 0;
    for (auto& entry : block.M) entry[i] = 0;
  }
  float sums[kTerms][TermBlock::kLanes];
  sumTerms(block, padded, sums);
  std::size_t term = 0;
  const auto total = [&sums, &term] {
    double sum = 0;
    for (const float lane : sums[term]) sum += static_cast<double>(lane);
    ++term;
    return sum;
  };
  for (int row = 0; row < 6; ++row)
    for (int col = row; col < 6; ++col) system.H(row, col) += total();
  for (int row = 0; row < 6; ++row) system.g(row) += total();
}

float countResidual(float distance_m, const MatchKernel& kernel, MatchSystem& system) {
  const auto gate = static_cast<float>(kernel.gate_m), inlier = static_cast<float>(kernel.inlier_m);
  if (!(distance_m < gate)) return 0.0f;
  const float r2 = distance_m * distance_m;
  const auto bin = static_cast<std::size_t>(distance_m * (static_cast<float>(MatchSystem::kBins) / gate));
  ++system.matched, ++system.clear_matched;
  ++system.histogram[std::min(bin, MatchSystem::kBins - 1)];
  if (distance_m <= inlier) {
    ++system.inliers, ++system.clear_inliers;
    system.inlier_r2 += static_cast<double>(r2);
    system.score += static_cast<double>(1.0f - r2 / (inlier * inlier));
  }
  const auto width2 = static_cast<float>(kernel.width_m * kernel.width_m);
  const float s = width2 / (width2 + r2);
  return s * s;
}

SurfelFinder::SurfelFinder(const SurfacePyramid& map, LevelRange levels, const Pose& T_map_scan) {
  for (int l = levels.finest; l <= levels.coarsest; ++l) {
    const double size = map.level(l).voxelSize();
    levels_.push_back(
        {&map.level(l), VoxelFrame(T_map_scan, size), static_cast<float>(size), static_cast<float>(1.0 / size)});
  }
}

const Surfel* SurfelFinder::find(const Eigen::Vector3f& p_scan, Eigen::Vector3f& offset) const {
  const Eigen::Vector3f turned = rotation() * p_scan;
  for (const Level& level : levels_) {
    const Eigen::Vector3f p = turned + level.frame.t;
    const VoxelCoord cell(floorToInt(p.x() * level.inverse_size), floorToInt(p.y() * level.inverse_size),
                          floorToInt(p.z() * level.inverse_size));
    const Surfel* surfel = level.surface->find(packVoxel(cell + level.frame.anchor));
    if (surfel == nullptr) continue;
    offset = p - cell.cast<float>() * level.size - Eigen::Vector3f(surfel->mx, surfel->my, surfel->mz);
    return surfel;
  }
  return nullptr;
}

MatchSystem lineariseLines(const SurfacePyramid& lines, LevelRange levels, const Cloud& source, const Pose& T_map_scan,
                           const MatchKernel& kernel, ThreadPool& threads) {
  const auto sigma2 = static_cast<float>(kernel.sigma_m * kernel.sigma_m);
  return lineariseTerms(
      lines, levels, source, T_map_scan, kernel, threads,
      [sigma2](std::size_t, const Surfel& line, const Eigen::Vector3f& u, const Eigen::Vector3f& d, float(&M)[6]) {
        const float w = 1.0f / (line.variance + sigma2);
        M[0] = w * (1 - u.x() * u.x()), M[1] = -w * u.x() * u.y(), M[2] = -w * u.x() * u.z();
        M[3] = w * (1 - u.y() * u.y()), M[4] = -w * u.y() * u.z(), M[5] = w * (1 - u.z() * u.z());
        return (d - u * u.dot(d)).norm();
      });
}

}  // namespace scslam
