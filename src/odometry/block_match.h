// Points against the surfels of a pyramid with a residual of three components: what lines (point-to-line) and
// distributions (generalised ICP) have in common. The plane metric has a narrower kernel of its own (scan_match.h).
//
//   minimise  sum_i d_i^T M_i d_i,   d_i = R^T (T_map_scan p_i - m_i),   M_i symmetric, in the frame of the scan
//
// over T_map_scan <- retract(T_map_scan, delta): the Jacobian of d_i is [I | -[p_i]x].
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "scslam/core/scan_match.h"

namespace scslam {

/// Points in flight; structure of arrays. M holds xx xy xz yy yz zz.
struct TermBlock {
  static constexpr std::size_t kSize = 128, kLanes = 8;
  alignas(32) float x[kSize], y[kSize], z[kSize];     ///< p, frame scan
  alignas(32) float dx[kSize], dy[kSize], dz[kSize];  ///< d, frame scan
  alignas(32) float M[6][kSize];
};

/// Adds the first n terms to system.H (upper triangle) and system.g. Entries up to the next multiple of kLanes are
/// overwritten with nothing.
void addTerms(TermBlock& block, std::size_t n, MatchSystem& system);

/// One residual: counted, and weighed with the kernel of Geman-McClure. @return its weight, 0 beyond the gate.
float countResidual(float distance_m, const MatchKernel& kernel, MatchSystem& system);

/// The surfel around a placed point of the finest level that has one, or nullptr.
/// @param offset of the point from the surfel's mean [m], frame map.
class SurfelFinder {
 public:
  SurfelFinder(const SurfacePyramid& map, LevelRange levels, const Pose& T_map_scan);
  const Surfel* find(const Eigen::Vector3f& p_scan, Eigen::Vector3f& offset) const;
  /// Rotation of T_map_scan.
  const Eigen::Matrix3f& rotation() const { return levels_.front().frame.R; }

 private:
  struct Level {
    const VoxelSurface* surface;
    VoxelFrame frame;
    float size, inverse_size;
  };
  std::vector<Level> levels_;
};

/// Linearises in chunks of fixed size: the same bits for any number of threads.
/// @param term (i, surfel, n, d, M) gives M (6 numbers) and returns the residual's length [m]; n and d in frame scan.
template <class Term>
MatchSystem lineariseTerms(const SurfacePyramid& map, LevelRange levels, const Cloud& source, const Pose& T_map_scan,
                           const MatchKernel& kernel, ThreadPool& threads, const Term& term) {
  constexpr std::size_t kChunk = 1024;
  const SurfelFinder finder(map, levels, T_map_scan);
  const Eigen::Matrix3f R_scan_map = finder.rotation().transpose();
  std::vector<MatchSystem> parts(chunkCount(source.size(), kChunk));
  threads.forEachChunk(source.size(), kChunk, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
    MatchSystem& system = parts[chunk];
    TermBlock block;
    std::size_t n = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const Eigen::Vector3f p = source.point(i);
      Eigen::Vector3f offset;
      const Surfel* surfel = finder.find(p, offset);
      if (surfel == nullptr) continue;
      const Eigen::Vector3f d = R_scan_map * offset;
      float M[6];
      const float distance =
          term(i, *surfel, Eigen::Vector3f(R_scan_map * Eigen::Vector3f(surfel->nx, surfel->ny, surfel->nz)), d, M);
      const float weight = countResidual(distance, kernel, system);
      if (weight <= 0.0f) continue;
      block.x[n] = p.x(), block.y[n] = p.y(), block.z[n] = p.z();
      block.dx[n] = d.x(), block.dy[n] = d.y(), block.dz[n] = d.z();
      for (int k = 0; k < 6; ++k) block.M[k][n] = weight * M[k];
      if (++n < TermBlock::kSize) continue;
      addTerms(block, n, system);
      n = 0;
    }
    addTerms(block, n, system);
  });
  MatchSystem total;
  total.points = static_cast<std::uint32_t>(source.size());
  for (const MatchSystem& part : parts) addSystem(part, total);
  total.H.triangularView<Eigen::StrictlyLower>() = total.H.transpose();
  return total;
}

/// Points to the lines that the surfels of `lines` hold (SurfelRules::edges): M = (I - u u^T) / (variance + sigma^2).
MatchSystem lineariseLines(const SurfacePyramid& lines, LevelRange levels, const Cloud& source, const Pose& T_map_scan,
                           const MatchKernel& kernel, ThreadPool& threads);

}  // namespace scslam
