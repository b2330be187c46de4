#include "scslam/registration/alignment_quality.h"

#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "scslam/core/scan_match.h"
#include "scslam/core/voxel_index.h"

namespace scslam {
namespace {

constexpr std::size_t kMostQuery = 1000, kMostTarget = 20000;
constexpr int kLeast = 5;          ///< points that say how they are spread
constexpr double kFloor_m = 0.05;  ///< of spreads: finer is noise

/// Sums of points, relative to the point they surround.
struct Moments {
  int n = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  void add(const Eigen::Vector3d& d) { ++n, sum += d, squares += d * d.transpose(); }
  Moments operator+(const Moments& other) const { return {n + other.n, sum + other.sum, squares + other.squares}; }
  /// Half the logarithm of the determinant of their covariance: the entropy, but for a constant.
  double entropy(int dimensions) const {
    const Eigen::Vector3d mean = sum / n;
    Eigen::Matrix3d C = squares / n - mean * mean.transpose();
    C.diagonal().array() += kFloor_m * kFloor_m;
    return 0.5 * std::log(dimensions == 2 ? C.topLeftCorner<2, 2>().determinant() : C.determinant());
  }
};

/// Points in cubes (squares) of the radius.
class Surroundings {
 public:
  Surroundings(const Cloud& cloud, double radius_m, bool planar)
      : cloud_(cloud), radius_(static_cast<float>(radius_m)), planar_(planar) {
    for (std::uint32_t i = 0; i < cloud.size(); ++i) {
      const std::uint32_t cell = index_.findOrInsert(keyOf(cloud.point(i), 0, 0, 0));
      if (cell == cells_.size()) cells_.emplace_back();
      cells_[cell].push_back(i);
    }
  }
  Moments of(const Eigen::Vector3f& p) const {
    Moments moments;
    for (int dz = planar_ ? 0 : -1; dz <= (planar_ ? 0 : 1); ++dz)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const std::uint32_t cell = index_.find(keyOf(p, dx, dy, dz));
          if (cell == VoxelIndex::kAbsent) continue;
          for (const std::uint32_t i : cells_[cell]) {
            Eigen::Vector3f d = cloud_.point(i) - p;
            if (planar_) d.z() = 0;
            if (d.squaredNorm() <= radius_ * radius_) moments.add(d.cast<double>());
          }
        }
    return moments;
  }

 private:
  VoxelKey keyOf(const Eigen::Vector3f& p, int dx, int dy, int dz) const {
    return packVoxel(floorToInt(p.x() / radius_) + dx, floorToInt(p.y() / radius_) + dy,
                     planar_ ? 0 : floorToInt(p.z() / radius_) + dz);
  }
  const Cloud& cloud_;
  float radius_;
  bool planar_;
  VoxelIndex index_;
  std::vector<std::vector<std::uint32_t>> cells_;
};

}  // namespace

AlignmentFeatures alignmentFeatures(const Cloud& query, const Cloud& target, const RegistrationResult& result,
                                    double radius_m, bool planar) {
  AlignmentFeatures features;
  features.rmse_m = result.rmse_m;
  const Cloud placed = transformed(thinned(query, kMostTarget), result.T_target_source);
  const Cloud other = thinned(target, kMostTarget);
  const Surroundings own(placed, radius_m, planar), theirs(other, radius_m, planar);
  const int dimensions = planar ? 2 : 3;
  int compared = 0, alone = 0;
  const Cloud asked = thinned(placed, kMostQuery);
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const Moments a = own.of(asked.point(i)), b = theirs.of(asked.point(i));
    if (a.n < kLeast) continue;
    if (b.n < kLeast) {
      ++alone;
      continue;
    }
    const double apart = (a.n * a.entropy(dimensions) + b.n * b.entropy(dimensions)) / (a.n + b.n);
    features.blur += (a + b).entropy(dimensions) - apart;
    ++compared;
  }
  if (compared > 0) features.blur /= compared;
  if (compared + alone > 0) features.shared = static_cast<double>(compared) / (compared + alone);
  return features;
}

void QualityParams::describe(ParamVisitor& v) {
  v.field("on", on, "is a registered pose judged by its quality, too");
  v.field("min_probability", min_probability, "that the pose is right", 0, 1);
  v.field("radius_m", radius_m, "of the surroundings of a point whose entropy is taken [m]", 0.05, 100);
  v.field("bias", bias, "weight of nothing; these four by 'scslam learn'");
  v.field("blur", blur, "weight of the entropy of both scans together above that of each alone [1/nat]");
  v.field("shared", shared, "weight of the share of points with the other scan around them");
  v.field("rmse_m", rmse_m, "weight of the residual [1/m]");
}

double probabilityOf(const AlignmentFeatures& f, const QualityParams& p) {
  const double score = p.bias + p.blur * f.blur + p.shared * f.shared + p.rmse_m * f.rmse_m;
  return 1 / (1 + std::exp(-score));
}

std::string refusal(const AlignmentFeatures& features, const QualityParams& params) {
  const double probability = probabilityOf(features, params);
  if (!params.on || probability >= params.min_probability) return "";
  return fmt::format("alignment quality {:.2f} < {:.2f} (blur {:.2f}, shared {:.2f})", probability,
                     params.min_probability, features.blur, features.shared);
}

}  // namespace scslam
