#include "scslam/apps/localize/localiser.h"
#include "scslam/graph/covariance.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "scslam/core/parallel.h"
#include "scslam/pipeline/factors.h"
#include "scslam/session/layout.h"

namespace scslam {
namespace {

/// Places that look this much less like the scan than the one that was found are no rivals of it.
constexpr double kRival = 1.5;

/// What a map and a moment's drift are off by even where everything is well: the least tolerance of a prediction.
const double kPrediction_m = 0.2, kPrediction_deg = 1.5;

Matrix6d variances(double sigma_m, double sigma_deg) {
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(sigma_m), Eigen::Vector3d::Constant(sigma_deg * M_PI / 180);
  return sigma.cwiseAbs2().asDiagonal();
}

bool near(const Pose& A, const Pose& B, double metres, double degrees) {
  const Vector6d d = local(A, B);
  return d.head<3>().norm() <= metres && d.tail<3>().norm() <= degrees * M_PI / 180;
}

/// Of a pose in the map that was measured by registration. Planar scans say nothing of height, roll and pitch; there
/// the robot stands as it stood when the map was made.
Matrix6d informationOf(const LoopRecord& record, const GraphParams& graph, bool planar) {
  const double kStands_m = 0.1, kStands_deg = 1;
  Matrix6d information = loopInformation(record, graph);
  if (planar)
    information.diagonal().segment<3>(2) += variances(kStands_m, kStands_deg).diagonal().segment<3>(2).cwiseInverse();
  return information;
}

/// The session's stored descriptors are of use when it was made with the same recogniser.
bool sameFirstRecogniser(const SavedMap& map, const PlaceParams& params) {
  if (map.session().info().config_yaml.empty()) return false;
  SlamParams made_with;
  try {
    loadYaml(made_with, map.session().info().config_yaml, "config.yaml");
  } catch (const Error&) {
    return false;
  }
  return dumpYaml(made_with.place) == dumpYaml(params);
}

}  // namespace

const char* nameOf(WhereState state) {
  switch (state) {
    case WhereState::kTracking:
      return "tracking";
    case WhereState::kCoasting:
      return "coasting";
    case WhereState::kSearching:
      break;
  }
  return "searching";
}

void LocalizeParams::describe(ParamVisitor& v) {
  v.field("confirmations", confirmations, "scans in a row that must be found at one place before it is believed", 1,
          100);
  v.field("agree_m", agree_m, "two findings agree within this, odometry in between [m]", 0.01, 100);
  v.field("agree_deg", agree_deg, "and this angle [deg]", 0.01, 180);
  v.field("lost_after_scans", lost_after_scans, "scans without a match to the map after which the robot is lost", 1,
          1000000);
  v.field("lost_after_m", lost_after_m, "or so much way without one [m]", 0.1, 1e6);
  v.field("restart_after_scans", restart_after_scans,
          "scans in a row that neither odometry nor the map can use after which odometry begins anew", 1, 1000000);
}

Localiser::Localiser(const SavedMap& map, const SlamParams& slam, const LocalizeParams& params,
                     const PluginContext& context)
    : map_(map),
      slam_(slam),
      params_(params),
      planar_(map.session().info().planar),
      recognisers_(slam.place.recognisers.create(context)),
      trial_(slam.registration, context, map.session().info().T_base_sensor.translation()) {
  const bool stored = sameFirstRecogniser(map, slam.place);
  constexpr std::size_t kBatch = 64;
  for (std::size_t r = 0; r < recognisers_.size(); ++r) {
    PlaceRecogniser& recogniser = *recognisers_[r];
    if (!recogniser.usesScans()) continue;
    const std::size_t n = map.keyframes().size();
    for (std::size_t begin = 0; begin < n; begin += kBatch) {
      std::vector<Descriptor> batch(std::min(kBatch, n - begin));
      context.threads.forEachChunk(batch.size(), 1, [&](std::size_t i, std::size_t, std::size_t) {
        const auto k = static_cast<KeyframeId>(begin + i);
        if (r == 0 && stored) batch[i] = map.session().descriptor(map.ownNumber(k));
        if (batch[i].size() == 0) batch[i] = recogniser.describe(map.keyframes()[k], map.wholeCloud(k));
      });
      for (std::size_t i = 0; i < batch.size(); ++i) recogniser.add(map.keyframes()[begin + i], batch[i]);
    }
  }
}

void Localiser::reset() { pending_.reset(), tracked_.reset(); }

void Localiser::odometryRestarted(const Pose& T_odom_base) {
  if (pending_ && !pending_->now) pending_.reset();
  if (pending_) pending_->T_odom_base = T_odom_base;
  if (tracked_) tracked_->T_odom_base = T_odom_base;
}

KeyframeId Localiser::nearestTo(const Eigen::Vector3d& p_map) const {
  KeyframeId nearest = 0;
  double best = std::numeric_limits<double>::max();
  for (KeyframeId k = 0; k < map_.poses().size(); ++k)
    if (const double d = (map_.poses()[k].translation() - p_map).squaredNorm(); d < best) best = d, nearest = k;
  return nearest;
}

void Localiser::setTarget(KeyframeId match) {
  trial_.setTarget(match, map_.keyframes(), static_cast<KeyframeId>(map_.keyframes().size()), map_.poses(),
                   [this](KeyframeId k) { return map_.cloud(k); });
}

Whereabouts Localiser::step(const OdometryStep& step) {
  const Cloud thinned = loopScan(step.cloud, slam_.registration);
  if (!tracked_) return search(step, thinned);
  Whereabouts where = track(step, thinned);
  if (where.state == WhereState::kTracking) return where;
  // Carried off while blind? The map may know this place before patience ends.
  Whereabouts again = search(step, thinned);
  where.odometry_doubted = again.odometry_doubted;
  return again.state == WhereState::kTracking ? again : where;
}

/// The one place that recognisers and registration agree on.
std::optional<Localiser::Fix> Localiser::recognised(const Keyframe& here, const OdometryStep& step,
                                                    const Cloud& thinned, std::string& note) {
  std::optional<Fix> found;
  for (const auto& recogniser : recognisers_) {
    if (!recogniser->usesScans()) continue;
    double found_at = std::numeric_limits<double>::infinity();  // distance at which this one knows the place found
    for (const PlaceCandidate& candidate : recogniser->find(here, recogniser->describe(here, step.cloud), thinned)) {
      const Pose& T_map_match = map_.poses()[candidate.match];
      const Pose T_map_guess = T_map_match * candidate.T_match_query;
      if (candidate.distance > kRival * found_at) break;
      // A second finding of the same place tells nothing new; one elsewhere does.
      if (found && near(found->T_map_base, T_map_guess, 3 + params_.agree_m, 30)) {
        found_at = std::min(found_at, candidate.distance);
        continue;
      }
      LoopRecord record;
      record.match = candidate.match;
      setTarget(candidate.match);
      trial_.verify(record, thinned, {candidate.T_match_query}, {candidate.T_match_query, Matrix6d::Zero(), 1e6},
                    planar_);
      if (!record.accepted || record.unfixed_axes > 0) {
        if (!found) note = record.accepted ? fmt::format("{} directions unfixed", record.unfixed_axes) : record.reason;
        continue;
      }
      const Pose T_map_base = T_map_match * record.T_match_query;
      if (found && !near(found->T_map_base, T_map_base, params_.agree_m, params_.agree_deg)) {
        note = "ambiguous: two places of the map fit";
        return std::nullopt;
      }
      const Matrix6d information = informationOf(record, slam_.graph, planar_);
      found = Fix{T_map_base, symmetric(information.inverse()), candidate.match};
      found_at = candidate.distance;
    }
  }
  if (!found && note.empty()) note = "no place of the map looks like this one";
  return found;
}

/// Is this the same place as the findings before, odometry in between?
bool Localiser::confirmed(const Fix& fix, const Pose& T_odom_base) {
  if (pending_) {
    const Pose T_step = pending_->T_odom_base.inverse() * T_odom_base;
    const double drift_m = 0.03 * T_step.translation().norm();
    if (!near(pending_->T_map_base * T_step, fix.T_map_base, params_.agree_m + drift_m, params_.agree_deg))
      pending_.reset();
  }
  pending_ = Pending{fix.T_map_base, T_odom_base, pending_ ? pending_->agreeing + 1 : 1, true};
  return pending_->agreeing >= params_.confirmations;
}

Whereabouts Localiser::search(const OdometryStep& step, const Cloud& thinned) {
  Whereabouts where;
  Keyframe here;
  here.T_odom_base = step.T_odom_base;
  here.planar = planar_;
  if (thinned.empty()) {
    where.note = "the scan has no points";
    return where;
  }
  const std::optional<Fix> fix = recognised(here, step, thinned, where.note);
  const bool had_pending = pending_.has_value();
  if (pending_) pending_->now = false;
  if (!fix) return where;
  if (!confirmed(*fix, step.T_odom_base)) {
    where.note = fmt::format("found near keyframe {}, not yet confirmed", fix->keyframe);
    where.odometry_doubted = had_pending && pending_->agreeing == 1;
    return where;
  }
  pending_.reset();
  where.state = WhereState::kTracking;
  where.T_map_base = fix->T_map_base, where.covariance = fix->covariance, where.keyframe = fix->keyframe;
  where.first_fix = true;
  where.note = tracked_ ? "found elsewhere" : "found";
  tracked_ = Tracked{fix->T_map_base, step.T_odom_base, fix->covariance};
  return where;
}

Whereabouts Localiser::track(const OdometryStep& step, const Cloud& thinned) {
  Tracked& at = *tracked_;
  const Pose T_step = at.T_odom_base.inverse() * step.T_odom_base;
  const Matrix6d step_covariance =
      symmetric(step.covariance) + variances(slam_.graph.odometry_floor_m, slam_.graph.odometry_floor_deg);
  at.T_map_base = at.T_map_base * T_step;
  at.T_odom_base = step.T_odom_base;
  at.covariance = symmetric(composeCovariance(at.covariance, T_step, step_covariance));
  at.since_match_m += T_step.translation().norm();

  Whereabouts where;
  LoopRecord record;
  record.match = nearestTo(at.T_map_base.translation());
  const Pose& T_map_match = map_.poses()[record.match];
  const Pose T_match_base = T_map_match.inverse() * at.T_map_base;
  if (thinned.empty()) {
    record.reason = "the scan has no points";
  } else if (T_match_base.translation().norm() > slam_.registration.gates.max_offset_m) {
    record.reason = "off the map";
  } else {
    setTarget(record.match);
    trial_.verify(record, thinned, {T_match_base},
                  {T_match_base, at.covariance + variances(kPrediction_m, kPrediction_deg), at.since_match_m}, planar_);
  }
  if (record.accepted) {
    const Matrix6d measured = informationOf(record, slam_.graph, planar_);
    const Matrix6d covariance = symmetric((Matrix6d(at.covariance.inverse()) + measured).inverse());
    const Vector6d correction = covariance * measured * local(at.T_map_base, T_map_match * record.T_match_query);
    at.T_map_base = retract(at.T_map_base, correction);
    at.covariance = covariance;
    at.misses = 0, at.since_match_m = 0;
    where.state = WhereState::kTracking;
    where.keyframe = record.match;
    pending_.reset();
  } else {
    ++at.misses;
    where.state = WhereState::kCoasting;
    where.note = record.reason;
  }
  where.T_map_base = at.T_map_base, where.covariance = at.covariance;
  if (at.misses >= params_.lost_after_scans || (at.misses > 0 && at.since_match_m > params_.lost_after_m)) {
    tracked_.reset();
    where = Whereabouts();
    where.note = "lost: " + record.reason;
  }
  return where;
}

}  // namespace scslam
