// Scan Context, polar form: G. Kim, S. Choi, A. Kim, "Scan Context++" (T-RO 2021), Sec. IV; re-implemented from the
// paper.
//
// A scan becomes a rings x sectors image around the sensor, levelled by gravity; a bin holds the height of its highest
// point above the ground. Turning the robot shifts the image's columns, so the best shift of the column-wise cosine
// distance is both the similarity and the heading difference, which is kept: it is where the registration starts.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "scslam/core/gravity.h"
#include "scslam/core/simd.h"
#include "scslam/place/place_recogniser.h"

namespace scslam {
namespace {

constexpr std::size_t kLanes = 8;
constexpr float kWorst = 1.0f;

/// Dot products of `a` with `b` shifted by 0, stride, 2*stride, …; n is a multiple of kLanes. Fixed summation order.
SCSLAM_KERNEL void shiftedDots(const float* a, const float* b, std::size_t n, std::size_t stride, std::size_t shifts,
                               float* out) {
  for (std::size_t s = 0; s < shifts; ++s) {
    const float* shifted = b + s * stride;
    float sum[kLanes] = {};
    for (std::size_t i = 0; i < n; i += kLanes)
      for (std::size_t lane = 0; lane < kLanes; ++lane) sum[lane] += a[i + lane] * shifted[i + lane];
    out[s] = ((sum[0] + sum[4]) + (sum[2] + sum[6])) + ((sum[1] + sum[5]) + (sum[3] + sum[7]));
  }
}

/// Squared distances of `key` to n keys stored one row per dimension (keys[d * capacity + k]).
SCSLAM_KERNEL void keyDistances(const float* key, const float* keys, std::size_t dimensions, std::size_t capacity,
                                std::size_t n, float* out) {
  for (std::size_t k = 0; k < n; ++k) out[k] = 0;
  for (std::size_t d = 0; d < dimensions; ++d) {
    const float* row = keys + d * capacity;
    const float value = key[d];
    for (std::size_t k = 0; k < n; ++k) out[k] += (row[k] - value) * (row[k] - value);
  }
}

class ScanContext : public PlaceRecogniser {
 public:
  struct Params : ParamSetOf<Params> {
    int rings = 20, sectors = 60, candidates_by_key = 50, candidates = 3;
    double max_radius_m = 80, max_distance = 0.45, min_travel_m = 15, distinct_travel_m = 10;
    void describe(ParamVisitor& v) override {
      v.field("rings", rings, "bins along the range", 4, 200);
      v.field("sectors", sectors, "bins around the sensor", 8, 64);
      v.field("max_radius_m", max_radius_m, "range of the outermost bin [m]", 1, 500);
      v.field("candidates_by_key", candidates_by_key, "places whose descriptors are compared in full", 1, 100000);
      v.field("candidates", candidates, "places handed to the registration at most", 1, 100);
      v.field("max_distance", max_distance,
              "descriptor distance above which two places do not look alike (0 same .. 1)", 0, 1);
      v.field("min_travel_m", min_travel_m, "a loop needs at least this much path in between [m]", 0, 1e6);
      v.field("distinct_travel_m", distinct_travel_m,
              "candidates nearer than this along the path count as one place [m]", 0, 1e4);
    }
  };

  ScanContext(const Params& params, const PluginContext&)
      : params_(params),
        rings_(static_cast<std::size_t>(params.rings)),
        sectors_(static_cast<std::size_t>(params.sectors)),
        column_((rings_ + kLanes - 1) / kLanes * kLanes) {}

  Descriptor describe(const Keyframe& keyframe, const Cloud& cloud_base) const override {
    Pose T_level_base = Pose::Identity();
    T_level_base.linear() = levelling(keyframe.T_odom_base);
    const Cloud cloud = transformed(cloud_base, T_level_base);
    const double ground = keyframe.planar ? 0 : groundHeight(cloud);
    Descriptor image = Descriptor::Zero(params_.rings, params_.sectors);
    const double ring_scale = params_.rings / params_.max_radius_m, sector_scale = params_.sectors / (2 * M_PI);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const double x = cloud.x[i], y = cloud.y[i];
      const double range = std::sqrt(x * x + y * y);
      if (range < 1e-3 || range >= params_.max_radius_m) continue;
      double azimuth = std::atan2(y, x);
      if (azimuth < 0) azimuth += 2 * M_PI;
      const int ring = std::min(static_cast<int>(range * ring_scale), params_.rings - 1);
      const int sector = std::min(static_cast<int>(azimuth * sector_scale), params_.sectors - 1);
      const auto height = keyframe.planar ? 1.0f : static_cast<float>(cloud.z[i] - ground);
      image(ring, sector) = std::max(image(ring, sector), height);
    }
    return image;
  }

  void add(const Keyframe& keyframe, const Descriptor& descriptor) override {
    if (descriptor.rows() != params_.rings || descriptor.cols() != params_.sectors)
      throw inputError("keyframe {}: the descriptor is {} x {}, the configuration says {} x {}", keyframe.id,
                       descriptor.rows(), descriptor.cols(), params_.rings, params_.sectors);
    const std::size_t k = keyframes_.size();
    keyframes_.push_back(keyframe);
    addKey(k, descriptor);
    // Normalised columns, stored twice in a row, so that every shift is one contiguous dot product.
    std::vector<float> columns(2 * sectors_ * column_, 0.0f);
    std::uint64_t valid = 0;
    for (std::size_t s = 0; s < sectors_; ++s) {
      const auto column = descriptor.col(static_cast<Eigen::Index>(s));
      const float norm = column.norm();
      if (norm <= 0) continue;
      valid |= std::uint64_t{1} << s;
      for (std::size_t r = 0; r < rings_; ++r)
        columns[s * column_ + r] = columns[(s + sectors_) * column_ + r] = column(static_cast<Eigen::Index>(r)) / norm;
    }
    columns_.push_back(std::move(columns));
    valid_.push_back(valid);
  }

  std::vector<PlaceCandidate> query(KeyframeId k) const override {
    const std::size_t eligible = eligibleBefore(k);
    std::vector<Scored> scored = nearestByKey(k, eligible);
    for (Scored& s : scored) compare(k, s);
    std::erase_if(scored, [this](const Scored& s) { return s.distance > params_.max_distance; });
    std::sort(scored.begin(), scored.end(), [](const Scored& a, const Scored& b) {
      return std::pair(a.distance, a.id) < std::pair(b.distance, b.id);
    });
    std::vector<PlaceCandidate> result;
    for (const Scored& s : scored) {
      const bool same_place = std::any_of(result.begin(), result.end(), [&](const PlaceCandidate& c) {
        return std::abs(keyframes_[c.match].travelled_m - keyframes_[s.id].travelled_m) < params_.distinct_travel_m;
      });
      if (same_place) continue;
      result.push_back({static_cast<KeyframeId>(s.id), s.distance, guess(s.id, k, s.yaw)});
      if (result.size() == static_cast<std::size_t>(params_.candidates)) break;
    }
    return result;
  }

 private:
  struct Scored {
    std::size_t id;
    float key_distance;
    double distance = kWorst, yaw = 0;
  };

  void addKey(std::size_t k, const Descriptor& descriptor) {
    if (k >= capacity_) {  // rows move apart; amortised over the doubling
      const std::size_t grown = std::max<std::size_t>(256, 2 * capacity_);
      std::vector<float> keys(rings_ * grown, 0.0f);
      for (std::size_t r = 0; r < rings_ && capacity_ > 0; ++r)
        std::copy_n(keys_.begin() + static_cast<std::ptrdiff_t>(r * capacity_), k,
                    keys.begin() + static_cast<std::ptrdiff_t>(r * grown));
      keys_ = std::move(keys);
      capacity_ = grown;
    }
    for (std::size_t r = 0; r < rings_; ++r)
      keys_[r * capacity_ + k] = descriptor.row(static_cast<Eigen::Index>(r)).mean();
  }

  /// Keyframes 0 .. n-1 are at least min_travel_m of path before k.
  std::size_t eligibleBefore(KeyframeId k) const {
    const double limit = keyframes_[k].travelled_m - params_.min_travel_m;
    const auto end = keyframes_.begin() + k;
    return static_cast<std::size_t>(std::upper_bound(keyframes_.begin(), end, limit,
                                                     [](double t, const Keyframe& f) { return t < f.travelled_m; }) -
                                    keyframes_.begin());
  }

  std::vector<Scored> nearestByKey(KeyframeId k, std::size_t eligible) const {
    std::vector<float> key(rings_), distance(eligible);
    for (std::size_t r = 0; r < rings_; ++r) key[r] = keys_[r * capacity_ + k];
    keyDistances(key.data(), keys_.data(), rings_, capacity_, eligible, distance.data());
    std::vector<Scored> scored;
    for (std::size_t i = 0; i < eligible; ++i) scored.push_back({i, distance[i]});
    const auto keep = std::min<std::size_t>(static_cast<std::size_t>(params_.candidates_by_key), eligible);
    std::partial_sort(scored.begin(), scored.begin() + static_cast<std::ptrdiff_t>(keep), scored.end(),
                      [](const Scored& a, const Scored& b) {
                        return std::pair(a.key_distance, a.id) < std::pair(b.key_distance, b.id);
                      });
    scored.resize(keep);
    return scored;
  }

  /// Distance over all column shifts (paper, Eq. 6, averaged over the columns both scans saw) and the yaw of the best
  /// one.
  void compare(KeyframeId query, Scored& s) const {
    std::array<float, 64> dots{};
    shiftedDots(columns_[query].data(), columns_[s.id].data(), sectors_ * column_, column_, sectors_, dots.data());
    std::array<double, 64> distance{};
    std::size_t best = 0;
    for (std::size_t shift = 0; shift < sectors_; ++shift) {
      const std::uint64_t rotated =
          shift == 0 ? valid_[s.id] : (valid_[s.id] >> shift | valid_[s.id] << (sectors_ - shift));
      const std::uint64_t mask = sectors_ == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << sectors_) - 1;
      const int common = std::popcount(valid_[query] & rotated & mask);
      // Fewer than a third of the columns in common say nothing about the place.
      distance[shift] = 3 * common < params_.sectors ? kWorst : 1 - static_cast<double>(dots[shift]) / common;
      if (distance[shift] < distance[best]) best = shift;
    }
    s.distance = distance[best];
    const double left = distance[(best + sectors_ - 1) % sectors_], right = distance[(best + 1) % sectors_];
    const double curvature = left - 2 * distance[best] + right;
    const double offset = curvature > 1e-9 ? std::clamp(0.5 * (left - right) / curvature, -0.5, 0.5)
                                           : 0;  // parabola through three shifts
    s.yaw = (static_cast<double>(best) + offset) * 2 * M_PI / params_.sectors;
  }

  /// The query turned by `yaw` about the vertical, seen from the match; both upright.
  Pose guess(std::size_t match, KeyframeId query, double yaw) const {
    Pose T = Pose::Identity();
    T.linear() = levelling(keyframes_[match].T_odom_base).transpose() *
                 Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix() *
                 levelling(keyframes_[query].T_odom_base);
    return T;
  }

  Params params_;
  std::size_t rings_, sectors_, column_;
  std::vector<Keyframe> keyframes_;
  std::vector<std::vector<float>> columns_;
  std::vector<std::uint64_t> valid_;  ///< bit s: column s is not empty
  std::vector<float> keys_;           ///< retrieval keys (row means), one row per ring
  std::size_t capacity_ = 0;
};

}  // namespace

SCSLAM_REGISTER(PlaceRecogniser, ScanContext, "scan_context",
                "Scan Context, polar 20 x 60, levelled by gravity, all column shifts (Kim et al. 2018/2021)")

}  // namespace scslam
