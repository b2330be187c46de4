// Precision and recall of a place recogniser over the threshold on its distance.
#pragma once
#include <cstddef>
#include <optional>
#include <vector>

namespace scslam {

/// One keyframe that was asked for, judged by the truth.
struct JudgedQuery {
  bool revisit = false;            ///< there is an earlier place to be found
  std::optional<double> distance;  ///< of the best candidate; absent: none was offered
  bool first_true = false;         ///< the best candidate is the same place
  bool five_true = false;          ///< one of the five best is
};

struct CurvePoint {
  double threshold = 0;  ///< best candidates up to this distance, itself included, are taken
  double precision = 0;  ///< true ones of those taken
  double recall = 0;     ///< revisits whose best candidate is taken and true
};

/// Absent figures have nothing to count: no revisit, or no candidate.
struct PrecisionRecall {
  std::size_t queries = 0, revisits = 0;
  std::vector<CurvePoint> curve;            ///< by rising threshold, one point for each distance that occurs
  std::optional<double> auc;                ///< sum of precision times step of recall (average precision)
  std::optional<double> f1_max;             ///< largest 2 P R / (P + R)
  std::optional<double> f1_threshold;       ///< where that is
  std::optional<double> recall_at_1;        ///< revisits whose best candidate is true, whatever its distance
  std::optional<double> recall_at_5;        ///< … one of the five best
  std::optional<double> recall_full;        ///< largest recall while precision is still exactly 1; 0: never
  std::optional<double> full_precision_at;  ///< the threshold that gives it
  std::optional<double> nearest_false;  ///< smallest distance of a best candidate that is wrong; also without revisits
};

/// The area is summed in steps, not by trapezes, which promise what no threshold reaches (Davis and Goadrich, "The
/// relationship between precision-recall and ROC curves", ICML 2006). A query that is no revisit, or whose best
/// candidate is another place, is a false alarm as soon as the threshold takes it.
PrecisionRecall precisionRecall(const std::vector<JudgedQuery>& queries);

}  // namespace scslam
