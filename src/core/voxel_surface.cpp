#include "scslam/core/voxel_surface.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace scslam {

namespace {

/// What the points of a voxel look like: their axis, and the two eigenvalues whose ratio tells how clear it is.
struct Shape {
  Eigen::Vector3d axis;  ///< normal of a plane, direction of a line
  double less, more;     ///< [m^2]
  double variance;       ///< that the surface's own noise makes [m^2]
};

Shape planeShape(const Eigen::Matrix3d& covariance) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.computeDirect(covariance);
  const Eigen::Vector3d v = eigen.eigenvalues();
  return {eigen.eigenvectors().col(0), v[0], v[1], v[0]};
}

Shape lineShape(const Eigen::Matrix3d& covariance) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.computeDirect(covariance);
  const Eigen::Vector3d v = eigen.eigenvalues();
  return {eigen.eigenvectors().col(2), v[1], v[2], 0.5 * (v[0] + v[1])};
}

Shape planarShape(const Eigen::Matrix3d& covariance) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen;
  eigen.computeDirect(covariance.topLeftCorner<2, 2>());
  const Eigen::Vector2d v = eigen.eigenvalues(), normal = eigen.eigenvectors().col(0);
  return {Eigen::Vector3d(normal.x(), normal.y(), 0.0), v[0], v[1], v[0]};
}

}  // namespace

VoxelFrame::VoxelFrame(const Pose& T, double voxel_m) : R(T.linear().cast<float>()) {
  const Eigen::Vector3d corner = (T.translation() / voxel_m).array().floor();
  anchor = corner.cast<int>();
  t = (T.translation() - corner * voxel_m).cast<float>();
}

void VoxelSurface::insert(const Cloud& cloud_b, const Pose& T_map_b) {
  constexpr std::size_t kBlock = 64;  // keys first, so that their cache lines are on the way when they are looked up
  const VoxelFrame frame(T_map_b, voxel_m_);
  const auto size = static_cast<float>(voxel_m_), inverse_size = static_cast<float>(1.0 / voxel_m_);
  std::vector<std::uint32_t> changed;
  VoxelKey keys[kBlock];
  Eigen::Vector3f from_centre[kBlock];
  for (std::size_t begin = 0; begin < cloud_b.size(); begin += kBlock) {
    const std::size_t n = std::min(kBlock, cloud_b.size() - begin);
    for (std::size_t k = 0; k < n; ++k) {
      const Eigen::Vector3f p = frame.place(cloud_b.point(begin + k));
      const VoxelCoord cell(floorToInt(p.x() * inverse_size), floorToInt(p.y() * inverse_size),
                            floorToInt(p.z() * inverse_size));
      from_centre[k] = p - (cell.cast<float>().array() + 0.5f).matrix() * size;
      keys[k] = packVoxel(cell + frame.anchor);
      index_.prefetch(keys[k]);
    }
    for (std::size_t k = 0; k < n; ++k) {
      const std::uint32_t voxel = voxelOf(keys[k]);
      if (add(moments_[voxel], from_centre[k])) changed.push_back(voxel);
    }
  }
  for (const std::uint32_t voxel : changed) {
    Moments& m = moments_[voxel];
    surfels_[voxel] = fitted(m);
    m.next_fit = std::ceil(1.25f * m.n);
  }
}

std::uint32_t VoxelSurface::voxelOf(VoxelKey key) {
  const std::uint32_t voxel = index_.findOrInsert(key);
  if (voxel == moments_.size()) {
    moments_.emplace_back().next_fit = static_cast<float>(rules_.min_points);
    surfels_.emplace_back();
  }
  return voxel;
}

bool VoxelSurface::add(Moments& m, const Eigen::Vector3f& d) const {
  if (m.n >= static_cast<float>(rules_.max_points)) return false;
  m.n += 1;
  m.x += d.x(), m.y += d.y(), m.z += d.z();
  m.xx += d.x() * d.x(), m.xy += d.x() * d.y(), m.xz += d.x() * d.z();
  m.yy += d.y() * d.y(), m.yz += d.y() * d.z(), m.zz += d.z() * d.z();
  if (m.n < m.next_fit) return false;
  m.next_fit = std::numeric_limits<float>::infinity();  // said once
  return true;
}

Surfel VoxelSurface::fitted(const Moments& m) const {
  const double n = m.n;
  const Eigen::Vector3d mean = Eigen::Vector3d(m.x, m.y, m.z) / n;
  Eigen::Matrix3d covariance;
  covariance << m.xx, m.xy, m.xz, m.xy, m.yy, m.yz, m.xz, m.yz, m.zz;
  covariance = covariance / n - mean * mean.transpose();
  const Shape shape = rules_.planar  ? planarShape(covariance)
                      : rules_.lines ? lineShape(covariance)
                                     : planeShape(covariance);

  Surfel surfel;
  surfel.count = m.n;
  const bool clear = shape.less <= static_cast<double>(rules_.max_flatness) * shape.more &&
                     shape.more >= static_cast<double>(rules_.min_spread) * voxel_m_ * voxel_m_;
  if (!clear || !shape.axis.allFinite()) return surfel;
  if (!rules_.lines && !rules_.planar && shape.less > static_cast<double>(rules_.clear_flatness) * shape.more)
    surfel.count = -m.n;
  const Eigen::Vector3f offset = (mean.array() + 0.5 * voxel_m_).cast<float>();
  surfel.mx = offset.x(), surfel.my = offset.y(), surfel.mz = offset.z();
  surfel.nx = static_cast<float>(shape.axis.x()), surfel.ny = static_cast<float>(shape.axis.y());
  surfel.nz = static_cast<float>(shape.axis.z());
  surfel.variance = static_cast<float>(std::max(shape.variance, 0.0));
  return surfel;
}

void VoxelSurface::forgetBeyond(const Eigen::Vector3d& centre, double radius_m, std::size_t budget) {
  const Eigen::Vector3d centre_voxel = centre / voxel_m_;
  const double radius2 = (radius_m / voxel_m_) * (radius_m / voxel_m_);
  for (std::size_t looked = std::min(budget, size()); looked > 0 && size() > 0; --looked) {
    if (sweep_ >= size()) sweep_ = 0;
    const VoxelCoord voxel = unpackVoxel(index_.keys()[sweep_]);
    if ((voxel.cast<double>() - centre_voxel).squaredNorm() <= radius2) {
      ++sweep_;
      continue;
    }
    index_.erase(static_cast<std::uint32_t>(sweep_));
    moments_[sweep_] = moments_.back();
    moments_.pop_back();
    surfels_[sweep_] = surfels_.back();
    surfels_.pop_back();
  }
}

Eigen::Vector3d VoxelSurface::upNear(const Eigen::Vector3d& centre, double radius_m) const {
  const Eigen::Vector3d centre_voxel = centre / voxel_m_;
  const double radius2 = (radius_m / voxel_m_) * (radius_m / voxel_m_);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < size(); ++i) {
    const Surfel& s = surfels_[i];
    if (!s.valid() || std::abs(s.nz) < 0.95f) continue;
    if ((unpackVoxel(index_.keys()[i]).cast<double>() - centre_voxel).squaredNorm() > radius2) continue;
    sum += std::copysign(1.0, static_cast<double>(s.nz)) * Eigen::Vector3d(s.nx, s.ny, s.nz);
  }
  return sum.norm() > 1e-6 ? Eigen::Vector3d(sum.normalized()) : Eigen::Vector3d::UnitZ();
}

void VoxelSurface::save(ByteWriter& state) const {
  state.put(index_.keys());
  state.put(moments_);
  state.put(surfels_);
  state.put(std::uint64_t{sweep_});
}

void VoxelSurface::load(ByteReader& state) {
  std::vector<VoxelKey> keys;
  state.get(keys);
  state.get(moments_);
  state.get(surfels_);
  sweep_ = state.get<std::uint64_t>();
  if (moments_.size() != keys.size() || surfels_.size() != keys.size())
    throw inputError("a voxel map's state is inconsistent: {} voxels, {} moments, {} surfels", keys.size(),
                     moments_.size(), surfels_.size());
  index_.assign(std::move(keys));
}

}  // namespace scslam
