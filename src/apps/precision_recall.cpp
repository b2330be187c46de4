#include "scslam/apps/precision_recall.h"

#include <algorithm>

namespace scslam {
namespace {

double share(std::size_t part, std::size_t whole) { return static_cast<double>(part) / static_cast<double>(whole); }

std::vector<JudgedQuery> byDistance(std::vector<JudgedQuery> queries) {
  std::erase_if(queries, [](const JudgedQuery& q) { return !q.distance; });
  std::stable_sort(queries.begin(), queries.end(),
                   [](const JudgedQuery& a, const JudgedQuery& b) { return *a.distance < *b.distance; });
  return queries;
}

void addCurve(PrecisionRecall& result, const std::vector<JudgedQuery>& taken) {
  std::size_t hits = 0;
  for (std::size_t i = 0; i < taken.size(); ++i) {
    hits += taken[i].first_true;
    const bool tied = i + 1 < taken.size() && *taken[i + 1].distance == *taken[i].distance;
    if (!tied) result.curve.push_back({*taken[i].distance, share(hits, i + 1), share(hits, result.revisits)});
  }
}

void addSummary(PrecisionRecall& result) {
  double area = 0, recall_before = 0;
  result.recall_full = 0;
  result.f1_max = 0;
  bool pure = true;
  for (const CurvePoint& p : result.curve) {
    area += p.precision * (p.recall - recall_before);
    recall_before = p.recall;
    const double sum = p.precision + p.recall, f1 = sum > 0 ? 2 * p.precision * p.recall / sum : 0;
    if (f1 > *result.f1_max) result.f1_max = f1, result.f1_threshold = p.threshold;
    pure = pure && p.precision == 1;
    if (pure) result.recall_full = p.recall, result.full_precision_at = p.threshold;
  }
  result.auc = area;
}

}  // namespace

PrecisionRecall precisionRecall(const std::vector<JudgedQuery>& queries) {
  PrecisionRecall result;
  result.queries = queries.size();
  std::size_t first = 0, five = 0;
  for (const JudgedQuery& q : queries) {
    const bool wrong = q.distance && !q.first_true;
    if (wrong && (!result.nearest_false || *q.distance < *result.nearest_false)) result.nearest_false = q.distance;
    result.revisits += q.revisit;
    first += q.revisit && q.first_true;
    five += q.revisit && q.five_true;
  }
  if (result.revisits == 0) return result;
  result.recall_at_1 = share(first, result.revisits);
  result.recall_at_5 = share(five, result.revisits);
  addCurve(result, byDistance(queries));
  addSummary(result);
  return result;
}

}  // namespace scslam
