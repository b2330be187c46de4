// Radar odometry by oriented surface points, scan to several keyframes: the approach of CFEAR (D. Adolfsson et al.,
// T-RO 2023), with a metric of its own.
//
// A group of points knows where it is as well as its points spread: little along a wall, well across it, in both
// directions for a pole. Each pair (a of the scan, b of a keyframe) is therefore weighed with the covariance of both,
//   minimise  sum rho( d^T S^-1 d ),   d = T_keyframe_scan a - b,   S = C_b + R C_a R^T,
// rho = Geman-McClure's kernel, whose width follows the residuals; pairs are the nearest groups with like directions,
// found anew in each iteration.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <deque>

#include "scslam/odometry/block_match.h"
#include "scslam/odometry/frontends/radar_surface/oriented_points.h"
#include "scslam/odometry/radar_odometry.h"

namespace scslam {
namespace {

using radar_surface::OrientedPoints;
using radar_surface::PointGrid;

struct Keyframe {
  Pose T_odom_base;
  OrientedPoints points;  ///< frame base of it
  PointGrid grid;
};

/// What a group says of the place of the surface in it. Its mean is known as well as its points spread; but where the
/// spread fills the group, as along a wall, the surface goes on beyond it and the mean is only that of the cut.
Eigen::Matrix2d covarianceOf(const OrientedPoints& points, std::size_t i, double radius_m, double sigma_m) {
  const auto of = [&](float spread) {
    constexpr double kLeast = 1e-3;
    const double filled = 4 * static_cast<double>(spread) / (radius_m * radius_m);  // 1 for a disc full of points
    const double own = std::max(1 - filled, kLeast);
    return static_cast<double>(spread / points.count[i]) / (own * own) + sigma_m * sigma_m;
  };
  const double along = of(points.along[i]), across = of(points.across[i]);
  const Eigen::Vector2d n(points.nx[i], points.ny[i]);
  return along * Eigen::Matrix2d::Identity() + (across - along) * n * n.transpose();
}

/// Spread along the surface is so many times that across it: has it a direction?
constexpr float kDirected = 5;
bool directed(const OrientedPoints& points, std::size_t i) { return points.along[i] > kDirected * points.across[i]; }

}  // namespace

class RadarSurface : public RadarOdometry {
 public:
  struct Params : ParamSetOf<Params>, RadarOdometryParams {
    double group_m = 0;
    int group_points = 4;
    int keyframes = 8;
    double keyframe_m = 1.5, keyframe_deg = 5;
    double direction_deg = 45;
    double sigma_m = 0;
    void describe(ParamVisitor& v) override {
      describeRadar(v);
      v.field("group_m", group_m, "radius of a group of points that makes a surface point [m]; 0: 0.75 voxel_m", 0.0,
              100.0);
      v.field("group_points", group_points, "smaller groups are left out", 2, 1000);
      v.field("keyframes", keyframes, "each sweep is matched with so many of the last keyframes", 1, 100);
      v.field("keyframe_m", keyframe_m, "a sweep becomes a keyframe so far from the last one [m]", 0.0, 1000.0);
      v.field("keyframe_deg", keyframe_deg, "or turned so far from it [deg]", 0.0, 360.0);
      v.field("direction_deg", direction_deg, "surfaces that match differ by less [deg]", 1.0, 90.0);
      v.field("sigma_m", sigma_m, "what a group's place is known to at best [m]; 0: 0.06 voxel_m", 0.0, 10.0);
    }
  };
  RadarSurface(const Params& params, const PluginContext& context) : RadarOdometry(params, context), params_(params) {}

 private:
  /// Most echoes of open country are clutter that comes and goes, and the oldest keyframes saw other parts of it.
  double leastInliers() const override { return 0.03; }

  std::string extract(const Cloud& cloud, const Scan& scan, Features& features) override {
    noteSensor(scan);
    features = {cloud};
    return "";
  }

  double groupRadius() const { return params_.group_m > 0 ? params_.group_m : 0.75 * voxelSize(); }
  OrientedPoints groupsOf(const Features& features) const {
    return radar_surface::orientedPoints(features[0], {groupRadius(), params_.group_points});
  }

  MatchResult match(const Features& features, const Guess& guess, const Pose& T_start) const override {
    const OrientedPoints groups = groupsOf(features);
    MatchOptions options = matchOptions(guess);
    if (params_.sigma_m > 0) options.sigma_m = params_.sigma_m;
    MatchKernel kernel;
    kernel.gate_m = groupRadius();
    kernel.width_m = 0.5 * kernel.gate_m;
    kernel.inlier_m = options.inlier_m;
    kernel.sigma_m = options.sigma_m;
    std::vector<Eigen::Matrix2d> covariances(groups.size());
    for (std::size_t i = 0; i < groups.size(); ++i)
      covariances[i] = covarianceOf(groups, i, groupRadius(), kernel.sigma_m);
    const auto against_keyframes = [&](const Pose& T_odom_base, const MatchKernel& now) {
      MatchSystem system;
      for (const Keyframe& keyframe : keyframes_) addPairs(keyframe, groups, covariances, T_odom_base, now, system);
      return system;
    };
    return matchBy(against_keyframes, T_start, kernel, leverOf(features[0]), options);
  }

  /// The group of the keyframe nearest to (x, y) whose direction fits, -1 if there is none.
  std::int64_t partner(const Keyframe& keyframe, const Eigen::Vector2f& at, const Eigen::Vector2f& normal,
                       bool has_direction, double gate_m) const {
    const OrientedPoints& b = keyframe.points;
    const auto least_cosine = static_cast<float>(std::cos(params_.direction_deg * M_PI / 180));
    auto nearest = static_cast<float>(gate_m * gate_m);
    std::int64_t found = -1;
    keyframe.grid.near(at.x(), at.y(), [&](std::uint32_t k) {
      const float dx = at.x() - b.x[k], dy = at.y() - b.y[k], distance2 = dx * dx + dy * dy;
      if (distance2 >= nearest) return;
      if (has_direction && directed(b, k) && std::abs(normal.x() * b.nx[k] + normal.y() * b.ny[k]) < least_cosine)
        return;
      nearest = distance2, found = k;
    });
    return found;
  }

  void addPairs(const Keyframe& keyframe, const OrientedPoints& groups, const std::vector<Eigen::Matrix2d>& covariances,
                const Pose& T_odom_base, const MatchKernel& kernel, MatchSystem& system) const {
    const Pose T_keyframe_base = keyframe.T_odom_base.inverse() * T_odom_base;
    const Eigen::Matrix2d R = T_keyframe_base.linear().topLeftCorner<2, 2>();
    const Eigen::Vector2d t = T_keyframe_base.translation().head<2>();
    const int axes[] = {0, 1, 5};
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    system.points += static_cast<std::uint32_t>(groups.size());
    for (std::size_t i = 0; i < groups.size(); ++i) {
      const Eigen::Vector2d a(groups.x[i], groups.y[i]), placed = R * a + t;
      const Eigen::Vector2d normal = R * Eigen::Vector2d(groups.nx[i], groups.ny[i]);
      const std::int64_t found =
          partner(keyframe, placed.cast<float>(), normal.cast<float>(), directed(groups, i), kernel.gate_m);
      if (found < 0) continue;
      const auto k = static_cast<std::size_t>(found);
      const Eigen::Vector2d b(keyframe.points.x[k], keyframe.points.y[k]),
          n(keyframe.points.nx[k], keyframe.points.ny[k]);
      const Eigen::Matrix2d S =
          covarianceOf(keyframe.points, k, groupRadius(), kernel.sigma_m) + R * covariances[i] * R.transpose();
      const Eigen::Matrix2d M = S.inverse();
      const Eigen::Vector2d d = placed - b;
      const double length = std::sqrt(d.dot(M * d) * n.dot(S * n));  // in metres across the surface
      const auto weight = static_cast<double>(countResidual(static_cast<float>(length), kernel, system));
      if (weight <= 0) continue;
      Eigen::Matrix<double, 2, 3> J;
      J << R, R * Eigen::Vector2d(-a.y(), a.x());
      H += weight * J.transpose() * M * J;
      g += weight * J.transpose() * (M * d);
    }
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) system.H(axes[r], axes[c]) += H(r, c);
      system.g(axes[r]) += g(r);
    }
  }

  void insert(const Features& features, const Pose& T_odom_base) override {
    ScanToMap::insert(features, T_odom_base);
    if (!keyframes_.empty()) {
      const Pose T_last_base = keyframes_.back().T_odom_base.inverse() * T_odom_base;
      if (T_last_base.translation().norm() < params_.keyframe_m &&
          rotationAngle(T_last_base) < params_.keyframe_deg * M_PI / 180)
        return;
    }
    addKeyframe(T_odom_base, groupsOf(features));
    while (keyframes_.size() > static_cast<std::size_t>(params_.keyframes)) keyframes_.pop_front();
  }

  void addKeyframe(const Pose& T_odom_base, OrientedPoints points) {
    PointGrid grid(points.x, points.y, groupRadius());
    keyframes_.push_back({T_odom_base, std::move(points), std::move(grid)});
  }

  void clearMap() override {
    ScanToMap::clearMap();
    keyframes_.clear();
  }

  void saveMap(ByteWriter& state) const override {
    ScanToMap::saveMap(state);
    state.put(std::uint64_t{keyframes_.size()});
    for (const Keyframe& keyframe : keyframes_) {
      state.put(keyframe.T_odom_base);
      keyframe.points.save(state);
    }
  }

  void loadMap(ByteReader& state) override {
    ScanToMap::loadMap(state);
    const auto count = state.get<std::uint64_t>();
    for (std::uint64_t k = 0; k < count; ++k) {
      Pose T_odom_base;
      OrientedPoints points;
      state.get(T_odom_base);
      points.load(state);
      addKeyframe(T_odom_base, std::move(points));
    }
  }

  Params params_;
  std::deque<Keyframe> keyframes_;  ///< oldest first
};

SCSLAM_REGISTER(Odometry, RadarSurface, "radar_surface",
                "radar: oriented surface points against several keyframes (CFEAR class)")

}  // namespace scslam
