// Places near by the map's own reckoning: every earlier keyframe that the drift since then may have brought here.
//
// The covariance of T_match_query follows from the odometry's covariances along the path in between. Front-ends are
// confident; a trust per metre of path is the least it may be. Loops closed in between make the map better than this
// says, which costs candidates that the registration refuses, not loops.
#include <algorithm>
#include <cmath>

#include "scslam/place/place_choice.h"

namespace scslam {
namespace {

class Radius : public PlaceRecogniser {
 public:
  struct Params : ParamSetOf<Params> {
    double radius_m = 5, sigmas = 2, sigma_per_m = 0.005, max_reach_m = 25;
    int candidates = 2;
    double min_travel_m = 15, distinct_travel_m = 10;
    void describe(ParamVisitor& v) override {
      v.field("radius_m", radius_m, "places at most this far apart, drift aside, overlap enough [m]", 0, 1000);
      v.field("sigmas", sigmas, "how many standard deviations of the drift are added to it", 0, 10);
      v.field("sigma_per_m", sigma_per_m, "the drift's standard deviation is at least this per metre of path [m/m]", 0,
              1);
      v.field("max_reach_m", max_reach_m, "never farther than this, whatever the drift [m]", 0, 10000);
      v.field("candidates", candidates, "places handed to the registration at most", 1, 100);
      v.field("min_travel_m", min_travel_m, "a loop needs at least this much path in between [m]", 0, 1e6);
      v.field("distinct_travel_m", distinct_travel_m,
              "candidates nearer than this along the path count as one place [m]", 0, 1e4);
    }
  };

  Radius(const Params& params, const PluginContext&)
      : params_(params),
        places_({.candidates = params.candidates,
                 .max_distance = params.max_reach_m,
                 .max_ratio = 1,
                 .min_travel_m = params.min_travel_m,
                 .distinct_travel_m = params.distinct_travel_m}) {}

  bool usesScans() const override { return false; }
  Descriptor describe(const Keyframe&, const Cloud&) const override { return {}; }

  void add(const Keyframe& keyframe, const Descriptor&, const Cloud&) override {
    // Sum of the steps' covariances, each carried to frame odom: any stretch of the path is a difference of two.
    const Matrix6d A = adjoint(keyframe.T_odom_base);
    const Matrix6d step = A * keyframe.step_covariance * A.transpose();
    const bool usable = places_.size() > 0 && step.allFinite();
    drift_odom_.push_back(drift_odom_.empty() ? Matrix6d::Zero() : drift_odom_.back());
    if (usable) drift_odom_.back() += step;
    places_.add(keyframe);
  }

  /// Keyframes added since are placed by odometry from the last one given.
  void setPoses(const std::vector<Pose>& T_map_base) override { T_map_base_ = T_map_base; }

  std::vector<PlaceCandidate> query(KeyframeId k) const override {
    const std::size_t eligible = places_.eligibleBefore(k);
    const Pose T_map_query = poseOf(k);
    std::vector<PlaceCandidate> ranking;
    for (std::size_t j = 0; j < eligible; ++j) {
      const Pose T_map_match = poseOf(j);
      const double distance = (T_map_query.translation() - T_map_match.translation()).norm();
      if (!(distance <= params_.max_reach_m)) continue;
      const Pose T_match_query = T_map_match.inverse() * T_map_query;
      if (distance > params_.radius_m + params_.sigmas * sigmaBetween(j, k, T_match_query)) continue;
      ranking.push_back({static_cast<KeyframeId>(j), distance, T_match_query, 0});
    }
    return places_.choose(std::move(ranking));
  }

 private:
  Pose poseOf(std::size_t k) const {
    if (k < T_map_base_.size()) return T_map_base_[k];
    if (T_map_base_.empty()) return places_[k].T_odom_base;
    const std::size_t last = T_map_base_.size() - 1;
    return T_map_base_[last] * places_[last].T_odom_base.inverse() * places_[k].T_odom_base;
  }

  /// Standard deviation of the distance between the two [m].
  double sigmaBetween(std::size_t match, std::size_t query, const Pose& T_match_query) const {
    const double trust = params_.sigma_per_m * (places_[query].travelled_m - places_[match].travelled_m);
    const Matrix6d A = adjoint(places_[query].T_odom_base.inverse());
    const Matrix6d covariance = A * (drift_odom_[query] - drift_odom_[match]) * A.transpose();  // frame query
    const Eigen::Vector3d towards = T_match_query.linear().transpose() * T_match_query.translation();
    const double norm = towards.norm();
    if (norm < 1e-9) return trust;
    const Eigen::Vector3d direction = towards / norm;
    const double variance = direction.dot(covariance.topLeftCorner<3, 3>() * direction);
    return std::sqrt(std::max(0.0, variance) + trust * trust);
  }

  Params params_;
  VisitedPlaces places_;
  std::vector<Matrix6d> drift_odom_;
  std::vector<Pose> T_map_base_;
};

}  // namespace

SCSLAM_REGISTER(PlaceRecogniser, Radius, "radius",
                "places near by the map's own poses, as far as the drift since then allows")

}  // namespace scslam
