// The surface a voxel holds: a plane fitted to all points that ever fell into it, kept as running moments.
//
// One look-up gives a point its plane, without a neighbour search and without normals of the scan itself; the plane
// averages the range noise of all its points (the statistics of NDT, Biber 2003, and of voxelised GICP, Koide 2021,
// used as a point-to-plane metric).
#pragma once
#include <cstdint>
#include <vector>

#include "scslam/core/bytes.h"
#include "scslam/core/cloud.h"
#include "scslam/core/voxel_index.h"

namespace scslam {

/// A plane, or (SurfelRules::lines) a straight line. Half a cache line. Position is relative to the voxel's low corner,
/// so that a map kilometres away from its origin keeps full float precision.
struct Surfel {
  float mx = 0, my = 0, mz = 0;  ///< mean of the points [m], from the voxel's low corner
  float nx = 0, ny = 0, nz = 0;  ///< unit normal (of a line: its direction); the sign means nothing
  float variance = -1;           ///< of the points along the normal (across the line) [m^2]; negative: none is held
  float count = 0;               ///< points in the fit; negative: a rough surface (SurfelRules::clear_flatness)

  bool rough() const { return count < 0; }
  bool valid() const { return variance >= 0; }
};

/// Which plane (or line) fits count.
struct SurfelRules {
  int min_points = 5;
  int max_points = 200;         ///< a full voxel takes no more points: the first drive anchors the map
  float max_flatness = 0.3f;    ///< smallest / middle eigenvalue of the covariance
  float clear_flatness = 0.3f;  ///< beyond it a plane is rough: it pulls, but any scan fits there
  float min_spread = 0.005f;    ///< middle eigenvalue / voxel_m^2: a single ring is a line and fixes no plane
  bool planar = false;          ///< 2-D data: lines in the x-y plane, normals horizontal
  bool lines = false;           ///< straight edges in space: max_flatness is middle / largest, min_spread the largest

  /// What was found best on recordings. A planar scan has few points and a cluttered room few clean lines: there a
  /// rough line, with its variance, is worth more than none.
  static SurfelRules of(bool planar) {
    SurfelRules rules;
    rules.planar = planar;
    if (planar) rules.min_points = 3, rules.max_flatness = 0.35f;
    return rules;
  }
  /// For odometry, which in open country has little but leaves, trunks and posts to go by: rough planes, too. Each
  /// counts by its own variance, and the posts' many planes look all ways.
  static SurfelRules rough(bool planar) {
    SurfelRules rules = of(planar);
    if (!planar) rules.max_flatness = 0.8f;
    return rules;
  }
  /// Edges of things, as LOAM defines them: one direction holds three times the variance of the next.
  static SurfelRules edges() {
    SurfelRules rules;
    rules.lines = true;
    rules.min_points = 4;
    rules.max_flatness = 1.0f / 3;
    rules.min_spread = 0.01f;
    return rules;
  }
};

/// A point's place relative to voxels: everything stays small numbers, whatever the distance from the map's origin.
struct VoxelFrame {
  VoxelCoord anchor;  ///< the voxel at T's translation
  Eigen::Matrix3f R;  ///< rotation of T
  Eigen::Vector3f t;  ///< translation of T from the low corner of `anchor` [m]

  VoxelFrame(const Pose& T, double voxel_m);
  Eigen::Vector3f place(const Eigen::Vector3f& p) const { return R * p + t; }
};

/// Voxels of one size.
class VoxelSurface {
 public:
  VoxelSurface(double voxel_m, const SurfelRules& rules) : voxel_m_(voxel_m), rules_(rules) {}

  double voxelSize() const { return voxel_m_; }
  std::size_t size() const { return index_.size(); }

  /// Adds the points (frame b) placed by T_map_b and refits the voxels that changed enough.
  void insert(const Cloud& cloud_b, const Pose& T_map_b);
  /// Forgets voxels farther than radius_m from `centre` (map frame), looking at most at `budget` voxels a call.
  void forgetBeyond(const Eigen::Vector3d& centre, double radius_m, std::size_t budget);

  void prefetch(VoxelKey key) const { index_.prefetch(key); }
  /// nullptr when the voxel is unknown or holds no plane.
  const Surfel* find(VoxelKey key) const {
    const std::uint32_t i = index_.find(key);
    return i != VoxelIndex::kAbsent && surfels_[i].valid() ? &surfels_[i] : nullptr;
  }
  bool occupied(VoxelKey key) const { return index_.find(key) != VoxelIndex::kAbsent; }
  /// Calls visit(VoxelCoord, const Surfel&) for every voxel that holds a plane, in the order in which they appeared.
  template <class Visit>
  void forEachPlane(Visit visit) const {
    for (std::size_t i = 0; i < surfels_.size(); ++i)
      if (surfels_[i].valid()) visit(unpackVoxel(index_.keys()[i]), surfels_[i]);
  }

  /// Mean direction of the planes within 18 degrees of level and radius_m of `centre`: the local up (ground, floors).
  /// @return +z where there are none.
  Eigen::Vector3d upNear(const Eigen::Vector3d& centre, double radius_m) const;

  void save(ByteWriter& state) const;
  void load(ByteReader& state);

 private:
  /// Sums over the points, relative to the voxel's centre.
  struct Moments {
    float n = 0;
    float next_fit = 0;  ///< refit when n reaches this
    float x = 0, y = 0, z = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  };
  std::uint32_t voxelOf(VoxelKey key);
  /// @param from_centre the point, from the voxel's centre. @return the voxel is to be refitted.
  bool add(Moments& moments, const Eigen::Vector3f& from_centre) const;
  Surfel fitted(const Moments& moments) const;

  double voxel_m_;
  SurfelRules rules_;
  VoxelIndex index_;
  std::vector<Moments> moments_;
  std::vector<Surfel> surfels_;
  std::size_t sweep_ = 0;  ///< next voxel that forgetBeyond() looks at
};

}  // namespace scslam
