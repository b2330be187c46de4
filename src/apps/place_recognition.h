// Place recognition alone, measured against the truth: no registration, no graph, no threshold chosen beforehand.
#pragma once
#include <string>
#include <vector>

#include "scslam/apps/precision_recall.h"
#include "scslam/pipeline/slam_params.h"

namespace scslam {

struct PlaceOptions {
  double revisit_radius_m = 3;  ///< a candidate truly this near the query is the same place
  double min_travel_m = 15;     ///< … when at least this much way lies between them
  double split_radius_m = 8;    ///< likewise, for the figures split by heading and offset (Scan Context++ counts so)
  RegistrationParams registration;  ///< recognisers keep scans thinned so (loopScan()), as those of a run do
};

/// A recogniser with its parameters.
struct PlaceVariant {
  std::string label;       ///< for people: "scan_context:rings=40"
  std::string recogniser;  ///< registered name
  std::shared_ptr<const ParamSet> params;
};

/// @param text "NAME" or "NAME:key=value,key=value", over `config`. The recogniser's own threshold (max_distance) is
/// opened as far as it goes, because the curve runs over it; its min_travel_m follows `options`, and it is asked for at
/// least five candidates.
/// @throw usageError for an unknown name or key, a value out of range, or a key that the measurement itself sets.
PlaceVariant placeVariant(const std::string& text, const SlamParams& config, const PlaceOptions& options);

/// Revisits of one class of relative pose to the nearest earlier place.
struct SplitCell {
  int heading_deg = -1;         ///< 0, 90 or 180: the nearest to the difference of headings; -1: all
  double from_m = 0, to_m = 0;  ///< lateral offset in the earlier keyframe's frame, [from, to)
  std::size_t revisits = 0;
  std::optional<double> recall_at_1, recall_full;  ///< the latter below the threshold that lets no false one pass
};

struct PlaceFigures {
  PlaceVariant variant;
  PrecisionRecall figures;               ///< same place = within revisit_radius_m
  PrecisionRecall split_figures;         ///< same place = within split_radius_m
  std::vector<SplitCell> split;          ///< three headings and all, each over the offsets and all of them
  double describe_ms = 0, query_ms = 0;  ///< means per keyframe: describe and add; query
  std::size_t descriptor_bytes = 0;
};

/// Feeds several recognisers the same keyframes as the pipeline would (describe, add, query), and judges what they
/// answer. Memory: the recognisers and a few candidates a keyframe; no cloud is kept.
class PlaceExperiment {
 public:
  PlaceExperiment(const std::vector<PlaceVariant>& variants, const PlaceOptions& options, const PluginContext& context);
  /// @param keyframe ids in order from 0; pose-based recognisers see T_odom_base. @param T_truth_base where it truly
  /// was; a keyframe without is neither asked for nor counted as found.
  void add(const Keyframe& keyframe, const Cloud& cloud_base, const std::optional<Pose>& T_truth_base);
  std::size_t keyframes() const { return keyframes_.size(); }
  std::size_t withTruth() const;
  /// In the order of the variants.
  std::vector<PlaceFigures> figures() const;

 private:
  struct Trial {
    PlaceVariant variant;
    std::unique_ptr<PlaceRecogniser> recogniser;
    std::vector<std::vector<PlaceCandidate>> answers;  ///< per keyframe, best first
    double describe_ms = 0, query_ms = 0;
    std::size_t descriptor_bytes = 0;
  };
  bool samePlace(KeyframeId match, KeyframeId query, double radius_m) const;
  std::vector<JudgedQuery> judge(const Trial& trial, double radius_m) const;
  PlaceFigures figuresOf(const Trial& trial) const;

  PlaceOptions options_;
  std::vector<Trial> trials_;
  std::vector<Keyframe> keyframes_;
  std::vector<Pose> T_odom_base_;
  std::vector<std::optional<Pose>> T_truth_base_;
};

/// What was measured on what.
struct PlaceReport {
  std::string input, keyframes_from;  ///< "session", "truth" or the front-end's name
  std::size_t keyframes = 0, with_truth = 0;
  PlaceOptions options;
  std::vector<PlaceFigures> variants;
};
std::string placeTable(const PlaceReport& report);
std::string placeJson(const PlaceReport& report);

}  // namespace scslam
