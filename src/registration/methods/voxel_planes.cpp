// Point-to-plane registration on a pyramid of voxel planes, coarse to fine: a grid of poses about the guess is scored
// on the coarsest planes, its best cells slide down the pyramid, and the one that fits best at the finest is kept.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "scslam/core/scan_match.h"
#include "scslam/core/voxel_filter.h"
#include "scslam/registration/conditioning.h"
#include "scslam/registration/registration.h"

namespace scslam {
namespace {

constexpr int kLevels = 3;  // the coarsest catches a poor guess

// Error that no number of points averages out: the submap's scans stand at poses of their own. Measured on reverse
// revisits of a street with surveyed poses (median error 0.02 m, 0.09 deg).
constexpr double kFloor_m = 0.015, kFloor_rad = 0.0015;

class VoxelPlanes : public Registration {
 public:
  struct Params : ParamSetOf<Params> {
    double voxel_m = 0;
    double inlier_m = 0;
    double search_yaw_deg = 10;
    double search_xy_m = 3;
    double search_z_m = 1;
    int max_iterations = 30;
    void describe(ParamVisitor& visitor) override {
      visitor.field("voxel_m", voxel_m, "finest voxel of the target [m]; 0: 0.5, planar data 0.05 of the median range",
                    0.0, 10.0);
      visitor.field("inlier_m", inlier_m, "gate of an inlier along the normal [m]; 0: 0.6 voxels", 0.0, 10.0);
      visitor.field("search_yaw_deg", search_yaw_deg, "how wrong the guess's heading may be [deg]", 0.0, 180.0);
      visitor.field("search_xy_m", search_xy_m, "how wrong the guess may be in x and y [m]", 0.0, 50.0);
      visitor.field("search_z_m", search_z_m, "how wrong the guess may be in z [m]", 0.0, 20.0);
      visitor.field("max_iterations", max_iterations, "Gauss-Newton iterations at the finest voxels", 1, 1000);
    }
  };

  VoxelPlanes(const Params& params, const PluginContext& context) : params_(params), context_(context) {}

  void setTarget(const Cloud& target) override {
    target_ = finiteAndThin(target);
    map_.reset();
  }

  using Registration::align;
  RegistrationResult align(const Cloud& source, const std::vector<Pose>& T_target_source_guesses,
                           bool planar) override {
    RegistrationResult result;
    result.T_target_source = T_target_source_guesses.front();
    if (!map_ || planar != planar_) buildMap(planar);
    if (map_->empty()) return result;

    const Cloud thin = sourcePoints(source);
    result.points = thin.size();
    const SearchResult search = searchFrom(*map_, thin, starts(T_target_source_guesses), options(), context_.threads);
    result = judged(thin, search.best);
    for (const RivalPose& rival : search.rivals) {
      constexpr double kNearlyAsWell = 0.85;
      constexpr std::size_t kAtMost = 3;
      if (rival.share < kNearlyAsWell || result.rivals.size() == kAtMost) break;
      if (!isNew(rival.T_map_scan, result)) continue;
      const MatchResult match = matchScan(*map_, thin, rival.T_map_scan, options(), context_.threads);
      if (!isNew(match.T_map_scan, result)) continue;  // it slid to one we have
      RegistrationResult other = judged(thin, match);
      other.fit = match.meanScore() / std::max(search.best.meanScore(), 1e-9);
      result.rivals.push_back(std::move(other));
    }
    return result;
  }

 private:
  /// The target thinned to what the finest voxels can use; kept because align() says whether the data is planar.
  Cloud finiteAndThin(const Cloud& cloud) const {
    constexpr std::size_t kThinAbove = 20000;
    const double leaf_m = params_.voxel_m > 0 ? 0.4 * params_.voxel_m : 0.2;
    return selected(cloud, onePerVoxel(cloud, cloud.size() > kThinAbove ? leaf_m : 1e-3));
  }

  Cloud sourcePoints(const Cloud& source) const {
    constexpr std::size_t kThinAbove = 2000;
    return selected(source, onePerVoxel(source, source.size() > kThinAbove ? 1.5 * voxel_m_ : 1e-3));
  }

  void buildMap(bool planar) {
    planar_ = planar;
    voxel_m_ = params_.voxel_m > 0 ? params_.voxel_m : planar ? planarVoxel() : 0.5;
    map_.emplace(voxel_m_, kLevels, SurfelRules::of(planar));
    map_->insert(target_, Pose::Identity());
    low_ = high_ = target_.empty() ? Eigen::Vector3f::Zero().eval() : target_.point(0);
    for (std::size_t i = 0; i < target_.size(); ++i) {
      low_ = low_.cwiseMin(target_.point(i));
      high_ = high_.cwiseMax(target_.point(i));
    }
  }

  double planarVoxel() const {
    std::vector<float> range2(target_.size());
    for (std::size_t i = 0; i < range2.size(); ++i) range2[i] = target_.point(i).squaredNorm();
    if (range2.empty()) return 0.15;
    const auto middle = range2.begin() + static_cast<std::ptrdiff_t>(range2.size() / 2);
    std::nth_element(range2.begin(), middle, range2.end());
    return std::clamp(0.05 * std::sqrt(static_cast<double>(*middle)), 0.15, 2.0);
  }

  MatchOptions options() const {
    MatchOptions options;
    options.levels = {0, kLevels - 1};
    options.max_iterations = params_.max_iterations;
    options.inlier_m = params_.inlier_m > 0 ? params_.inlier_m : 0.6 * voxel_m_;
    options.sigma_m = planar_ ? std::max(0.06 * voxel_m_, 0.02) : 0.06 * voxel_m_;
    options.planar = planar_;
    options.degenerate_share = 2e-4;  // the step may go where conditioningOf() sees nothing fixed: that is taken back
    return options;
  }

  PoseGrid grid() const {
    PoseGrid grid;
    grid.yaw_range_rad = params_.search_yaw_deg * M_PI / 180;
    grid.yaw_step_rad = 0.07;
    grid.xy_range_m = params_.search_xy_m;
    grid.xy_step_m = std::max(2.0 * voxel_m_, params_.search_xy_m / 10);
    grid.z_range_m = planar_ ? 0.0 : params_.search_z_m;
    grid.z_step_m = voxel_m_;
    grid.max_points = 200;
    grid.candidates = 5;
    return grid;
  }

  /// The first guess with the whole grid, its mirror image with a coarse one, and the others where they lie outside.
  std::vector<SearchStart> starts(const std::vector<Pose>& guesses) const {
    const PoseGrid whole = grid();
    PoseGrid coarse = whole;
    coarse.xy_step_m = 4 * voxel_m_;
    coarse.z_range_m = 0;
    Pose half_turn = guesses.front();
    half_turn.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()).toRotationMatrix() * half_turn.linear();
    std::vector<SearchStart> starts = {{guesses.front(), whole}, {half_turn, coarse}};
    for (std::size_t i = 1; i < guesses.size(); ++i) {
      const Vector6d d = local(guesses.front(), guesses[i]);
      const bool inside = d.head<3>().norm() < whole.xy_range_m && d.tail<3>().norm() < whole.yaw_range_rad;
      if (!inside && isRigid(guesses[i])) starts.push_back({guesses[i], coarse});
    }
    return starts;
  }

  /// The pose once more on the finest planes, with the noise that the residuals show: where that is low, planes tilted
  /// by an edge in their voxel weigh little against flat ones.
  Pose polished(const Cloud& source, const MatchResult& match) const {
    MatchOptions last = options();
    last.levels = {0, 0};
    last.max_iterations = 3;
    const MatchResult finest = matchScan(*map_, source, match.T_map_scan, last, context_.threads);
    if (4 * finest.system.matched < match.system.matched) return match.T_map_scan;  // sparse: coarse planes are needed
    const double shown_m = 1.4826 * finest.system.medianResidual(map_->level(0).voxelSize());
    last.sigma_m = std::clamp(shown_m, 0.1 * last.sigma_m, last.sigma_m);
    last.step_m = 2e-5, last.step_rad = 2e-6;
    last.max_iterations = 10;
    return matchScan(*map_, source, finest.T_map_scan, last, context_.threads).T_map_scan;
  }

  RegistrationResult judged(const Cloud& source, const MatchResult& match) const {
    constexpr double kLeastShare = 2e-3;
    const MatchSystem& system = match.system;
    const Conditioning conditioning = conditioningOf(system.H, source, kLeastShare, planar_);

    RegistrationResult result;
    result.points = source.size();
    result.T_target_source = polished(source, match);
    result.converged = match.converged && match.inlierRatio() > 0.05;
    result.iterations = match.iterations;
    result.inlier_ratio = system.matched > 0 ? static_cast<double>(system.inliers) / system.matched : 0.0;
    result.explained = match.inlierRatio();
    result.overlap = overlap(source, match.T_map_scan);
    result.rmse_m = match.rmse();
    result.degenerate_axes = conditioning.unfixed_axes;
    result.unfixed = conditioning.unfixed;
    result.hessian = believable(conditioning.information / MatchResult::kCorrelatedPoints);
    return result;
  }

  /// Another pose than the best one and its rivals so far: not the same reached less well, nor one farther along an
  /// unfixed direction.
  bool isNew(const Pose& T_target_source, const RegistrationResult& best) const {
    constexpr double kAngle_rad = 0.2;
    const auto differs = [&](const RegistrationResult& other) {
      const Vector6d d = local(other.T_target_source, T_target_source), fixed = d - other.unfixed * d;
      return fixed.head<3>().norm() > 4 * voxel_m_ || fixed.tail<3>().norm() > kAngle_rad;
    };
    return differs(best) && std::all_of(best.rivals.begin(), best.rivals.end(), differs);
  }

  /// Share of the source inside the target's bounding box that lies in an occupied voxel of the second level.
  double overlap(const Cloud& source, const Pose& T_target_source) const {
    const VoxelSurface& level = map_->level(1);
    const auto inverse = static_cast<float>(1.0 / level.voxelSize());
    const Eigen::Isometry3f T = T_target_source.cast<float>();
    std::size_t inside = 0, occupied = 0;
    for (std::size_t i = 0; i < source.size(); ++i) {
      const Eigen::Vector3f p = T * source.point(i);
      if ((p.array() < low_.array() - 0.5f).any() || (p.array() > high_.array() + 0.5f).any()) continue;
      ++inside;
      occupied += level.occupied(
          packVoxel(floorToInt(p.x() * inverse), floorToInt(p.y() * inverse), floorToInt(p.z() * inverse)));
    }
    return inside ? static_cast<double>(occupied) / static_cast<double>(inside) : 0.0;
  }

  /// The floor is added to the covariance: (I^-1 + F)^-1, written so that unfixed directions stay unfixed. They keep
  /// the information of a kilometre, which no graph feels, so that the matrix can be inverted.
  Matrix6d believable(const Matrix6d& information) const {
    constexpr double kNext_to_nothing = 1e-6;
    const Matrix6d known = information + kNext_to_nothing * Matrix6d::Identity();
    Vector6d floor;
    floor << Eigen::Vector3d::Constant(kFloor_m * kFloor_m), Eigen::Vector3d::Constant(kFloor_rad * kFloor_rad);
    const Matrix6d hessian = known * (Matrix6d::Identity() + floor.asDiagonal() * known).inverse();
    return 0.5 * (hessian + hessian.transpose());
  }

  Params params_;
  PluginContext context_;
  Cloud target_;
  std::optional<SurfacePyramid> map_;
  bool planar_ = false;
  double voxel_m_ = 0.5;
  Eigen::Vector3f low_ = Eigen::Vector3f::Zero(), high_ = Eigen::Vector3f::Zero();
};

}  // namespace

SCSLAM_REGISTER(Registration, VoxelPlanes, "voxel_planes",
                "coarse-to-fine point-to-plane on voxel planes, searches about the guess")

}  // namespace scslam
