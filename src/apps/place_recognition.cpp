#include "scslam/apps/place_recognition.h"

#include <algorithm>
#include <array>
#include <chrono>

#include "scslam/apps/place_recognition_truth.h"
#include "scslam/pipeline/loop_scans.h"

namespace scslam {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::size_t kFive = 5;

double msSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

int headingClass(double heading_deg) { return heading_deg < 45 ? 0 : heading_deg < 135 ? 90 : 180; }

/// Edges of the offsets [m]; the last one takes in all that counts as the same place.
std::array<double, 5> offsetEdges(double radius_m) { return {0, 1, 3, 5, std::max(8.0, radius_m) + 1e-9}; }

SplitCell cellOf(int heading_deg, double from_m, double to_m, const std::vector<std::optional<NearestPlace>>& nearest,
                 const std::vector<JudgedQuery>& queries, double full_precision_at) {
  SplitCell cell{heading_deg, from_m, to_m, 0, std::nullopt, std::nullopt};
  std::size_t first = 0, sure = 0;
  for (std::size_t k = 0; k < queries.size(); ++k) {
    if (!queries[k].revisit || nearest[k]->lateral_m < from_m || nearest[k]->lateral_m >= to_m) continue;
    if (heading_deg >= 0 && headingClass(nearest[k]->heading_deg) != heading_deg) continue;
    ++cell.revisits;
    first += queries[k].first_true;
    sure += queries[k].first_true && *queries[k].distance <= full_precision_at;
  }
  if (cell.revisits == 0) return cell;
  cell.recall_at_1 = static_cast<double>(first) / static_cast<double>(cell.revisits);
  cell.recall_full = static_cast<double>(sure) / static_cast<double>(cell.revisits);
  return cell;
}

}  // namespace

PlaceExperiment::PlaceExperiment(const std::vector<PlaceVariant>& variants, const PlaceOptions& options,
                                 const PluginContext& context)
    : options_(options) {
  options_.split_radius_m = std::max(options.split_radius_m, options.revisit_radius_m);
  for (const PlaceVariant& variant : variants) {
    Trial trial;
    trial.variant = variant;
    trial.recogniser = Registry<PlaceRecogniser>::instance().create(variant.recogniser, *variant.params, context);
    trials_.push_back(std::move(trial));
  }
}

void PlaceExperiment::add(const Keyframe& keyframe, const Cloud& cloud_base, const std::optional<Pose>& T_truth_base) {
  keyframes_.push_back(keyframe);
  T_odom_base_.push_back(keyframe.T_odom_base);
  T_truth_base_.push_back(T_truth_base);
  const Cloud kept = loopScan(cloud_base, options_.registration);
  for (Trial& trial : trials_) {
    const bool scans = trial.recogniser->usesScans();
    auto start = Clock::now();
    const Descriptor descriptor = scans ? trial.recogniser->describe(keyframe, cloud_base) : Descriptor();
    trial.recogniser->add(keyframe, descriptor, scans ? kept : Cloud());
    trial.describe_ms += msSince(start);
    trial.descriptor_bytes = static_cast<std::size_t>(descriptor.size()) * sizeof(float);
    trial.recogniser->setPoses(T_odom_base_);
    start = Clock::now();
    std::vector<PlaceCandidate> candidates = trial.recogniser->query(keyframe.id);
    trial.query_ms += msSince(start);
    candidates.resize(std::min(candidates.size(), kFive));
    trial.answers.push_back(std::move(candidates));
  }
}

std::size_t PlaceExperiment::withTruth() const {
  return static_cast<std::size_t>(
      std::count_if(T_truth_base_.begin(), T_truth_base_.end(), [](const auto& T) { return T.has_value(); }));
}

bool PlaceExperiment::samePlace(KeyframeId match, KeyframeId query, double radius_m) const {
  if (keyframes_[query].travelled_m - keyframes_[match].travelled_m < options_.min_travel_m) return false;
  if (!T_truth_base_[match] || !T_truth_base_[query]) return false;
  return (T_truth_base_[match]->translation() - T_truth_base_[query]->translation()).norm() <= radius_m;
}

/// One entry per keyframe; those without truth are no revisits and have no candidate.
std::vector<JudgedQuery> PlaceExperiment::judge(const Trial& trial, double radius_m) const {
  const auto nearest = nearestPlaces(keyframes_, T_truth_base_, radius_m, options_.min_travel_m);
  std::vector<JudgedQuery> queries(keyframes_.size());
  for (std::size_t k = 0; k < queries.size(); ++k) {
    if (!T_truth_base_[k]) continue;
    JudgedQuery& query = queries[k];
    query.revisit = nearest[k].has_value();
    for (const PlaceCandidate& candidate : trial.answers[k]) {
      if (!T_truth_base_[candidate.match]) continue;  // nobody knows whether it is right
      const bool is_true = samePlace(candidate.match, static_cast<KeyframeId>(k), radius_m);
      if (!query.distance) query.distance = candidate.distance, query.first_true = is_true;
      query.five_true |= is_true;
    }
  }
  return queries;
}

PlaceFigures PlaceExperiment::figuresOf(const Trial& trial) const {
  PlaceFigures result;
  result.variant = trial.variant;
  result.figures = precisionRecall(judge(trial, options_.revisit_radius_m));
  const std::vector<JudgedQuery> queries = judge(trial, options_.split_radius_m);
  result.split_figures = precisionRecall(queries);
  const auto nearest = nearestPlaces(keyframes_, T_truth_base_, options_.split_radius_m, options_.min_travel_m);
  const double sure = result.split_figures.full_precision_at.value_or(-1);
  const auto edges = offsetEdges(options_.split_radius_m);
  for (const int heading : {0, 90, 180, -1}) {
    for (std::size_t e = 0; e + 1 < edges.size(); ++e)
      result.split.push_back(cellOf(heading, edges[e], edges[e + 1], nearest, queries, sure));
    result.split.push_back(cellOf(heading, edges.front(), edges.back(), nearest, queries, sure));
  }
  const double n = std::max<double>(1, static_cast<double>(keyframes_.size()));
  result.describe_ms = trial.describe_ms / n;
  result.query_ms = trial.query_ms / n;
  result.descriptor_bytes = trial.descriptor_bytes;
  return result;
}

std::vector<PlaceFigures> PlaceExperiment::figures() const {
  std::vector<PlaceFigures> result;
  for (const Trial& trial : trials_) result.push_back(figuresOf(trial));
  return result;
}

}  // namespace scslam
