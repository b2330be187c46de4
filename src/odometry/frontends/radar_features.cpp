// Radar odometry by features, sweep to sweep: the class of Yeti (K. Burnett et al., RA-L 2021). Strong echoes are
// keypoints, binary descriptors of the image around them find each in the sweep before, pairs that disagree with the
// others are pruned, and a constant velocity that takes every keypoint at its own instant is found by RANSAC.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "scslam/odometry/frontends/radar_features/descriptors.h"
#include "scslam/odometry/frontends/radar_features/motion.h"
#include "scslam/odometry/radar_odometry.h"

namespace scslam {

using namespace radar_features;

class RadarFeatures : public RadarOdometry {
 public:
  struct Params : ParamSetOf<Params>, RadarOdometryParams {
    int keypoints = 400;
    double patch_m = 0, reach_m = 0, inlier_m = 0;
    int max_bits = 90;
    double ratio = 0.9;
    int ransac_iterations = 200;
    void describe(ParamVisitor& v) override {
      describeRadar(v);
      v.field("keypoints", keypoints, "at most so many of the strongest echoes a sweep", 10, 5000);
      v.field("patch_m", patch_m, "radius of what a descriptor sees [m]; 0: 2.5 voxel_m", 0.0, 100.0);
      v.field("reach_m", reach_m, "a keypoint is looked for so far from where it is expected [m]; 0: 3 voxel_m", 0.0,
              100.0);
      v.field("inlier_m", inlier_m, "pairs that fit the motion to this count [m]; 0: 0.3 voxel_m", 0.0, 10.0);
      v.field("max_bits", max_bits, "descriptors that match differ in fewer of 256 bits", 1, 256);
      v.field("ratio", ratio, "and in fewer than this share of the next best's", 0.1, 1.0);
      v.field("ransac_iterations", ransac_iterations, "hypotheses a sweep", 1, 100000);
    }
  };
  RadarFeatures(const Params& params, const PluginContext& context) : RadarOdometry(params, context), params_(params) {}

 private:
  /// Elements of Features.
  enum Part : std::size_t { kAll, kKeypoints };

  /// A sweep as another one is matched with it.
  struct Seen {
    Stamp stamp{};
    std::vector<float> x, y, dt;          ///< of the keypoints as they were seen, frame base at their instants
    std::vector<float> x_still, y_still;  ///< at the stamp
    std::vector<Descriptor> descriptors;
  };

  /// RANSAC itself compensates: the first sweep needs no velocity.
  bool compensatesFirst() const override { return false; }

  std::string extract(const Cloud& cloud, const Scan& scan, Features& features) override {
    if (!scan.radar) {
      constexpr const char* kWhy = "radar_features needs radar images, and this scan has none";
      if (!started()) throw inputError("scan {}: {}: choose another odometry.frontend", scan.index, kWhy);
      return kWhy;
    }
    noteSensor(scan);
    features = {cloud, strongest(cloud)};
    const Cloud& keypoints = features[kKeypoints];
    present_ = {};
    present_.stamp = scan.stamp;
    present_.x = keypoints.x, present_.y = keypoints.y, present_.dt = keypoints.dt;
    present_.dt.resize(keypoints.size(), 0.0f);
    beta_s_ = scan.radar->doppler_beta_s;
    field_ = PowerField(*scan.radar, patch() / 8);
    places_ = {};
    const Pose T_sensor_base = sensor().inverse();
    for (std::size_t i = 0; i < keypoints.size(); ++i) {
      const Eigen::Vector3d p = T_sensor_base * keypoints.point(i).cast<double>();
      places_.x.push_back(static_cast<float>(p.x())), places_.y.push_back(static_cast<float>(p.y()));
    }
    return "";
  }

  Cloud strongest(const Cloud& cloud) const {
    const auto most = static_cast<std::size_t>(params_.keypoints);
    if (cloud.size() <= most || !cloud.hasIntensity()) return cloud;
    std::vector<std::uint32_t> order(cloud.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return cloud.intensity[a] > cloud.intensity[b]; });
    std::vector<std::uint8_t> keep(cloud.size(), 0);
    for (std::size_t k = 0; k < most; ++k) keep[order[k]] = 1;
    Cloud kept = cloud;
    kept.filter(keep);
    return kept;
  }

  double patch() const { return params_.patch_m > 0 ? params_.patch_m : 2.5 * scale(); }
  double reach() const { return params_.reach_m > 0 ? params_.reach_m : 3 * scale(); }
  double inlier() const { return params_.inlier_m > 0 ? params_.inlier_m : 0.3 * scale(); }
  double scale() const { return voxelSize(); }

  /// Pairs whose descriptors are each other's nearest.
  std::vector<Pair> pairsOf(const Features& features, const Pose& T_last_start, double gap_s) const {
    const auto now = describe(field_, places_, patch(), -yawOf(T_last_start), threads());
    const Cloud& keypoints = features[kKeypoints];
    const auto reach2 = static_cast<float>(reach() * reach()), apart2 = static_cast<float>(scale() * scale());
    std::vector<std::int64_t> partner(now.size(), -1);
    std::vector<int> taken_at(last_.x.size(), params_.max_bits + 1);
    std::vector<std::int64_t> taken_by(last_.x.size(), -1);
    std::vector<std::pair<std::size_t, int>> near;  // keypoints within reach and their distance in bits
    for (std::size_t i = 0; i < now.size(); ++i) {
      const Eigen::Vector3f at = (T_last_start * keypoints.point(i).cast<double>()).cast<float>();
      int best = params_.max_bits;
      std::int64_t found = -1;
      const auto within = [&](std::size_t k) {
        const float dx = at.x() - last_.x_still[k], dy = at.y() - last_.y_still[k];
        return dx * dx + dy * dy <= reach2;
      };
      near.clear();
      for (std::size_t k = 0; k < last_.x.size(); ++k) {
        if (!within(k)) continue;
        const int bits = distanceOf(now[i], last_.descriptors[k]);
        near.emplace_back(k, bits);
        if (bits < best) best = bits, found = static_cast<std::int64_t>(k);
      }
      if (found < 0) continue;
      // The next best is another place: neighbours of the best one look like it.
      const auto b = static_cast<std::size_t>(found);
      int next = 256;
      for (const auto& [k, bits] : near) {
        const float dx = last_.x_still[k] - last_.x_still[b], dy = last_.y_still[k] - last_.y_still[b];
        if (dx * dx + dy * dy > apart2) next = std::min(next, bits);
      }
      if (best > params_.ratio * next || best >= taken_at[b]) continue;
      if (taken_by[b] >= 0) partner[static_cast<std::size_t>(taken_by[b])] = -1;
      partner[i] = found, taken_by[b] = static_cast<std::int64_t>(i), taken_at[b] = best;
    }
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < now.size(); ++i) {
      if (partner[i] < 0) continue;
      const auto b = static_cast<std::size_t>(partner[i]);
      Pair pair;
      pair.a = {present_.x[i], present_.y[i]}, pair.b = {last_.x[b], last_.y[b]};
      pair.a_still = {keypoints.x[i], keypoints.y[i]}, pair.b_still = {last_.x_still[b], last_.y_still[b]};
      if (gap_s > 0)
        pair.time = gap_s + static_cast<double>(present_.dt[i]) - static_cast<double>(last_.dt[b]);
      else
        pair.a = pair.a_still, pair.b = pair.b_still;
      pairs.push_back(pair);
    }
    return pairs;
  }

  /// What is known of the time between the sweep before and this one.
  struct Gap {
    bool timed = false;
    double unit = 1;                     ///< of a step [s]; without times the step itself is the twist
    double last_middle = 0, middle = 0;  ///< mean time of the keypoints after their stamps [s]
  };
  Gap gap() const {
    constexpr double kShortest = 1e-3, kLongest = 2;  // [s]: over which a constant velocity means something
    const double seconds = secondsBetween(last_.stamp, present_.stamp);
    if (!(seconds > kShortest && seconds < kLongest) || params_.deskew == "off") return {};
    return {true, seconds, meanOf(last_.dt), meanOf(present_.dt)};
  }
  static double meanOf(const std::vector<float>& values) {
    double sum = 0;
    for (const float value : values) sum += static_cast<double>(value);
    return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
  }
  /// Where poses go on from, and how long that is before the present stamp.
  Pose fromMiddle() const { return T_last_middle_.value_or(T_last_); }
  double sinceMiddle(const Gap& between) const {
    return T_last_middle_ ? between.unit - between.last_middle : between.unit;
  }
  /// Of the present sweep at T_odom_base; nothing when its velocity is not known.
  std::optional<Pose> middleOf(const Pose& T_odom_base) const {
    constexpr double kShortest = 0.02;  // [s]
    const Gap between = gap();
    if (last_.x.empty() || !between.timed || sinceMiddle(between) < kShortest) return std::nullopt;
    const Pose T_moved = fromMiddle().inverse() * T_odom_base;
    Eigen::Isometry2d T = Eigen::Isometry2d::Identity();
    T.linear() = T_moved.linear().topLeftCorner<2, 2>(), T.translation() = T_moved.translation().head<2>();
    return T_odom_base * lifted(moved(twistOfMotion(T, sinceMiddle(between)), between.middle));
  }
  static Pose lifted(const Eigen::Isometry2d& T) {
    return poseFromYaw(std::atan2(T.linear()(1, 0), T.linear()(0, 0)), {T.translation().x(), T.translation().y(), 0});
  }

  MatchResult match(const Features& features, const Guess& /*guess*/, const Pose& T_start) const override {
    MatchResult result;
    result.T_map_scan = T_start;
    const Gap between = gap();
    const Pose T_last_start = T_last_.inverse() * T_start;
    const std::vector<Pair> pairs = pairsOf(features, T_last_start, between.timed ? between.unit : 0.0);
    const std::vector<Pair> kept = pruned(pairs, 2 * inlier());
    MotionModel model;
    model.sensor = sensor().translation().head<2>();
    model.doppler_beta = between.timed ? beta_s_ : 0.0;
    const Eigen::Vector3d start(T_last_start.translation().x(), T_last_start.translation().y(), yawOf(T_last_start));
    const Motion motion = motionOf(kept, start / between.unit, model, {params_.ransac_iterations, inlier(), kSeed});
    result.system.points = static_cast<std::uint32_t>(std::min(present_.x.size(), last_.x.size()));
    result.system.matched = static_cast<std::uint32_t>(pairs.size());
    if (!motion.found) return result;
    // The velocity is that between the middles of both sweeps. Where the car brakes it was another between their
    // stamps: poses go from middle to middle.
    result.T_map_scan = fromMiddle() * lifted(moved(motion.twist, sinceMiddle(between)));
    result.converged = true;
    result.iterations = params_.ransac_iterations;
    addFigures(kept, motion, result);
    return result;
  }

  void addFigures(const std::vector<Pair>& pairs, const Motion& motion, MatchResult& result) const {
    MatchSystem& system = result.system;
    system.inliers = static_cast<std::uint32_t>(motion.inliers.size());
    for (const double r : motion.residuals) {
      system.inlier_r2 += r * r;
      system.score += 1 - r * r / (inlier() * inlier());
    }
    const double variance = std::max(system.inlier_r2 / system.inliers, 0.01 * inlier() * inlier());
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    for (const std::uint32_t i : motion.inliers) {
      Eigen::Matrix<double, 2, 3> J;
      J << 1, 0, -pairs[i].a.y(), 0, 1, pairs[i].a.x();
      H += J.transpose() * J / variance;
    }
    const int axes[] = {0, 1, 5};
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) result.information(axes[r], axes[c]) = H(r, c) / kCorrelatedPairs;
  }

  void insert(const Features& features, const Pose& T_odom_base) override {
    ScanToMap::insert({features[kAll]}, T_odom_base);
    T_last_middle_ = middleOf(T_odom_base);
    last_ = present_;
    last_.x_still = features[kKeypoints].x, last_.y_still = features[kKeypoints].y;
    last_.descriptors = describe(field_, places_, patch(), 0, threads());
    T_last_ = T_odom_base;
  }

  void saveMap(ByteWriter& state) const override {
    ScanToMap::saveMap(state);
    state.put(T_last_);
    state.put(T_last_middle_.has_value());
    state.put(T_last_middle_.value_or(Pose::Identity()));
    state.put(std::int64_t{last_.stamp.time_since_epoch().count()});
    for (const auto* values : {&last_.x, &last_.y, &last_.dt, &last_.x_still, &last_.y_still}) state.put(*values);
    state.put(last_.descriptors);
  }

  void loadMap(ByteReader& state) override {
    ScanToMap::loadMap(state);
    state.get(T_last_);
    const bool middle_known = state.get<bool>();
    Pose T_middle;
    state.get(T_middle);
    T_last_middle_ = middle_known ? std::optional(T_middle) : std::nullopt;
    last_.stamp = Stamp(Stamp::duration(state.get<std::int64_t>()));
    for (auto* values : {&last_.x, &last_.y, &last_.dt, &last_.x_still, &last_.y_still}) {
      state.get(*values);
      if (values->size() != last_.x.size()) throw inputError("odometry: saved keypoints of different numbers");
    }
    state.get(last_.descriptors);
    if (last_.descriptors.size() != last_.x.size()) throw inputError("odometry: saved keypoints of different numbers");
  }

  static constexpr std::uint32_t kSeed = 1;
  static constexpr double kCorrelatedPairs = 4;  ///< neighbouring azimuths see the same echo

  Params params_;
  Pose T_last_ = Pose::Identity();     ///< T_odom_base of last_
  std::optional<Pose> T_last_middle_;  ///< of the base in the middle of that sweep, frame odom
  Seen last_;

  // Of the present scan, made by extract().
  Seen present_;
  PowerField field_;
  Places places_;
  double beta_s_ = 0;
};

SCSLAM_REGISTER(Odometry, RadarFeatures, "radar_features",
                "radar: keypoints and descriptors, motion-compensated RANSAC (Yeti class)")

}  // namespace scslam
