// A scan against a map of voxel planes: point-to-plane Gauss-Newton on SE(3), or on SE(2) for planar data.
//
//   minimise  sum_i rho( n_i . (T_map_scan p_i - m_i) ) / variance_i      over T_map_scan <- retract(T_map_scan, delta)
//
// with the plane (m_i, n_i) of the finest voxel around T_map_scan p_i that holds one, and rho Geman-McClure's kernel
// whose width follows the median residual of the iteration before.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "scslam/core/parallel.h"
#include "scslam/core/voxel_surface.h"

namespace scslam {

/// Voxel planes at sizes voxel_m, 2 voxel_m, 4 voxel_m, …; level 0 is the finest.
class SurfacePyramid {
 public:
  SurfacePyramid(double voxel_m, int levels, const SurfelRules& rules);

  bool empty() const { return levels_.front().size() == 0; }
  int levels() const { return static_cast<int>(levels_.size()); }
  const VoxelSurface& level(int i) const { return levels_[static_cast<std::size_t>(i)]; }

  void insert(const Cloud& cloud_b, const Pose& T_map_b);
  void forgetBeyond(const Eigen::Vector3d& centre, double radius_m, std::size_t budget);
  void save(ByteWriter& state) const;
  void load(ByteReader& state);

 private:
  std::vector<VoxelSurface> levels_;
};

/// Levels of a pyramid that a match looks at, tried from `finest` on for each point.
struct LevelRange {
  int finest = 0;
  int coarsest = 0;
};

/// What one pass over the source gives.
struct MatchSystem {
  static constexpr std::size_t kBins = 64;
  Matrix6d H = Matrix6d::Zero();                       ///< sum w J^T J, w = kernel weight / variance
  Vector6d g = Vector6d::Zero();                       ///< sum w J^T r
  std::uint32_t points = 0;                            ///< of the source
  std::uint32_t matched = 0;                           ///< found a plane within the gate
  std::uint32_t inliers = 0;                           ///< |r| <= inlier_m
  std::uint32_t clear_matched = 0, clear_inliers = 0;  ///< of those, on planes that are not rough
  double inlier_r2 = 0;                                ///< sum of r^2 over the inliers [m^2]
  double score = 0;                                    ///< sum over the source of max(0, 1 - (r / inlier_m)^2)
  std::array<std::uint32_t, kBins> histogram{};        ///< of |r| over [0, gate)

  /// From the histogram; the gate when nothing matched.
  double medianResidual(double gate_m) const;
};

/// Adds the sums, the counts (except `points`) and the histogram of a part.
void addSystem(const MatchSystem& part, MatchSystem& total);

struct MatchKernel {
  double width_m = 0.3;    ///< of Geman-McClure
  double gate_m = 1.0;     ///< residuals beyond are no match
  double inlier_m = 0.15;  ///< what counts as an inlier
  double sigma_m = 0.03;   ///< noise of a point along the normal, added to the plane's own variance
};

/// One linearisation at T_map_scan. The same bits for any number of threads.
MatchSystem linearise(const SurfacePyramid& map, LevelRange levels, const Cloud& source, const Pose& T_map_scan,
                      const MatchKernel& kernel, ThreadPool& threads);

/// Mean over the points of max(0, 1 - (r / inlier_m)^2) at one level; 0 for points without a plane.
double matchScore(const SurfacePyramid& map, int level, const Cloud& source, const Pose& T_map_scan, double inlier_m);

struct MatchOptions {
  LevelRange levels;
  int max_iterations = 20;
  double step_m = 5e-4;    ///< converged when the update is smaller than this …
  double step_rad = 5e-5;  ///< … and than this
  double inlier_m = 0.15;
  double sigma_m = 0.03;
  double degenerate_share = 2e-3;  ///< a direction with less than this share of the information is degenerate
  bool planar = false;             ///< x, y and yaw only
  std::array<bool, 6> held{};      ///< axes (of the scan's frame) that keep their guess, besides those of `planar`
  Matrix6d guess_information = Matrix6d::Zero();  ///< how far the guess itself is to be believed (tangent, frame scan)
  std::optional<Pose> T_map_scan_believed;        ///< what guess_information is about; nothing: where the match starts
};

struct MatchResult {
  Pose T_map_scan = Pose::Identity();
  MatchSystem system;  ///< at the solution
  double kernel_width_m = 0;
  bool converged = false;
  int iterations = 0;
  int degenerate_axes = 0;  ///< 0..6 (0..3 when planar)

  /// Information of T_map_scan that can be believed (tangent of core/pose.h, frame scan): points that share a voxel
  /// share its map error, so kCorrelatedPoints of them count as one; degenerate directions carry none.
  Matrix6d information = Matrix6d::Zero();
  /// Takes the part of a tangent vector (frame scan) that lies in the degenerate directions: what the match leaves
  /// open.
  Matrix6d unfixed = Matrix6d::Zero();

  /// Measured: makes the mean normalised error of steps on a surveyed drive about 1.
  static constexpr double kCorrelatedPoints = 15.0;

  /// Without rough planes, which fit any scan: what tells a wrong place from the right one.
  double clearRatio() const { return system.points ? static_cast<double>(system.clear_inliers) / system.points : 0.0; }
  double inlierRatio() const { return system.points ? static_cast<double>(system.inliers) / system.points : 0.0; }
  double rmse() const;
  double meanScore() const { return system.points ? system.score / system.points : 0.0; }
};

/// Gauss-Newton from T_map_scan_guess. Directions that neither the data nor guess_information fixes keep their guess.
/// An empty source or map: not converged.
MatchResult matchScan(const SurfacePyramid& map, const Cloud& source, const Pose& T_map_scan_guess,
                      const MatchOptions& options, ThreadPool& threads);

/// matchScan() with a linearisation of the caller's own (lines, distributions): it fills H, g, the counts and the
/// histogram of a MatchSystem at a pose.
/// @param kernel of the first iteration; its width then follows the residuals.
/// @param lever_m what a radian is worth in metres when directions are compared: leverOf(source).
using Lineariser = std::function<MatchSystem(const Pose& T_map_scan, const MatchKernel& kernel)>;
MatchResult matchBy(const Lineariser& linearise_at, const Pose& T_map_scan_start, MatchKernel kernel, double lever_m,
                    const MatchOptions& options);

/// Root mean square distance of the points from their origin [m], at least 1 mm.
double leverOf(const Cloud& source);

/// Where to look when the guess may be far off: a grid around it, scored on the coarsest level.
struct PoseGrid {
  double yaw_range_rad = 0;  ///< half width; pi or more: the full turn
  double yaw_step_rad = 0.1;
  double xy_range_m = 0;  ///< half width of the square
  double xy_step_m = 1;
  double z_range_m = 0;
  double z_step_m = 0.5;
  std::size_t max_points = 300;  ///< of the source, spread evenly
  int candidates = 6;            ///< best cells that are refined
};

/// matchScan() from the guess and from the best cells of the grid about it (yaw about the
/// local ground's normal, shifts in the map frame); the result with the highest mean score, ties to the cell nearest
/// the guess.
MatchResult searchAndMatch(const SurfacePyramid& map, const Cloud& source, const Pose& T_map_scan_guess,
                           const PoseGrid& grid, const MatchOptions& options, ThreadPool& threads);

/// Another place where the scan fits, found on the way to the best one.
struct RivalPose {
  Pose T_map_scan = Pose::Identity();
  double share = 0;  ///< of the best one's mean score
};

struct SearchResult {
  MatchResult best;
  std::vector<RivalPose> rivals;  ///< every start's end, best first; those that ended at the best pose among them
};

/// Where searchFrom() begins: a grid about a guess.
struct SearchStart {
  Pose T_map_scan_guess;
  PoseGrid grid;
};

/// searchAndMatch() from several starts at once: the cells of all grids compete. The first start's grid says how many
/// points and cells are used.
SearchResult searchFrom(const SurfacePyramid& map, const Cloud& source, const std::vector<SearchStart>& starts,
                        const MatchOptions& options, ThreadPool& threads);

/// Every k-th point, at most max_points, evenly spread.
Cloud thinned(const Cloud& cloud, std::size_t max_points);

}  // namespace scslam
