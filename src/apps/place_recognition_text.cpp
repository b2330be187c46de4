#include <algorithm>
#include <nlohmann/json.hpp>

#include "scslam/apps/place_recognition.h"

namespace scslam {
namespace {

using Json = nlohmann::ordered_json;

Json orNull(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

std::string figure(const std::optional<double>& value) { return value ? fmt::format("{:.3f}", *value) : "-"; }

Json summaryJson(const PrecisionRecall& f) {
  return {{"queries", f.queries},
          {"revisits", f.revisits},
          {"auc", orNull(f.auc)},
          {"f1_max", orNull(f.f1_max)},
          {"f1_threshold", orNull(f.f1_threshold)},
          {"recall_at_1", orNull(f.recall_at_1)},
          {"recall_at_5", orNull(f.recall_at_5)},
          {"recall_at_full_precision", orNull(f.recall_full)},
          {"full_precision_threshold", orNull(f.full_precision_at)},
          {"nearest_false", orNull(f.nearest_false)}};
}

Json variantJson(const PlaceFigures& v) {
  Json json = {{"variant", v.variant.label}, {"recogniser", v.variant.recogniser}};
  json.update(summaryJson(v.figures));
  json["describe_ms"] = v.describe_ms;
  json["query_ms"] = v.query_ms;
  json["descriptor_bytes"] = v.descriptor_bytes;
  json["curve"] = Json::array();
  for (const CurvePoint& p : v.figures.curve)
    json["curve"].push_back({{"threshold", p.threshold}, {"precision", p.precision}, {"recall", p.recall}});
  json["split"] = {{"figures", summaryJson(v.split_figures)}, {"cells", Json::array()}};
  for (const SplitCell& cell : v.split)
    json["split"]["cells"].push_back({{"heading_deg", cell.heading_deg < 0 ? Json("all") : Json(cell.heading_deg)},
                                      {"lateral_m", {cell.from_m, cell.to_m}},
                                      {"revisits", cell.revisits},
                                      {"recall_at_1", orNull(cell.recall_at_1)},
                                      {"recall_at_full_precision", orNull(cell.recall_full)}});
  json["parameters"] = dumpYaml(*v.variant.params);
  return json;
}

std::string splitTable(const PlaceFigures& v, std::size_t width) {
  constexpr std::size_t kColumns = 5;  // four bins of offset, and all
  std::string text = fmt::format("{:<{}}", v.variant.label, width);
  for (std::size_t c = 0; c < kColumns; ++c)
    text += fmt::format(
        "{:>20}", c + 1 == kColumns ? "all offsets" : fmt::format("{:g}–{:.3g} m", v.split[c].from_m, v.split[c].to_m));
  text += "\n";
  for (std::size_t row = 0; row * kColumns < v.split.size(); ++row) {
    const int heading = v.split[row * kColumns].heading_deg;
    text += fmt::format("{:>{}}", heading < 0 ? "all headings" : fmt::format("{}°", heading), width);
    for (std::size_t c = 0; c < kColumns; ++c) {
      const SplitCell& cell = v.split[row * kColumns + c];
      text += fmt::format("{:>20}", cell.revisits == 0 ? "-"
                                                       : fmt::format("{:.2f} / {:.2f} ({})", *cell.recall_at_1,
                                                                     *cell.recall_full, cell.revisits));
    }
    text += "\n";
  }
  return text;
}

}  // namespace

std::string placeTable(const PlaceReport& report) {
  const PlaceOptions& o = report.options;
  std::size_t width = 26;
  for (const PlaceFigures& v : report.variants) width = std::max(width, v.variant.label.size() + 2);
  const std::size_t revisits = report.variants.empty() ? 0 : report.variants.front().figures.revisits;
  std::string text = fmt::format(
      "{}: {} keyframes from {}, {} with truth; {} revisit an earlier place (within {:g} m, {:g} m of way between)\n",
      report.input, report.keyframes, report.keyframes_from, report.with_truth, revisits, o.revisit_radius_m,
      o.min_travel_m);
  text += fmt::format("{:<{}}{:>8}{:>8}{:>8}{:>8}{:>8}{:>9}{:>8}{:>11}{:>14}{:>12}{:>9}\n", "", width, "AUC", "F1max",
                      "at", "R@1", "R@5", "R@P=1", "below", "false at", "describe [ms]", "query [ms]", "[bytes]");
  for (const PlaceFigures& v : report.variants) {
    const PrecisionRecall& f = v.figures;
    text += fmt::format("{:<{}}{:>8}{:>8}{:>8}{:>8}{:>8}{:>9}{:>8}{:>11}{:>14.3f}{:>12.3f}{:>9}\n", v.variant.label,
                        width, figure(f.auc), figure(f.f1_max), figure(f.f1_threshold), figure(f.recall_at_1),
                        figure(f.recall_at_5), figure(f.recall_full), figure(f.full_precision_at),
                        figure(f.nearest_false), v.describe_ms, v.query_ms, v.descriptor_bytes);
  }
  text += fmt::format(
      "\nrecall@1 / recall at 100 % precision (revisits) by heading difference and lateral offset to the nearest\n"
      "earlier place; here everything within {:g} m is the same place\n",
      std::max(o.split_radius_m, o.revisit_radius_m));
  for (const PlaceFigures& v : report.variants) text += splitTable(v, width);
  return text;
}

std::string placeJson(const PlaceReport& report) {
  Json json = {{"input", report.input},
               {"keyframes", report.keyframes},
               {"keyframes_from", report.keyframes_from},
               {"keyframes_with_truth", report.with_truth},
               {"revisit_radius_m", report.options.revisit_radius_m},
               {"min_travel_m", report.options.min_travel_m},
               {"split_radius_m", std::max(report.options.split_radius_m, report.options.revisit_radius_m)},
               {"variants", Json::array()}};
  for (const PlaceFigures& v : report.variants) json["variants"].push_back(variantJson(v));
  return json.dump(2) + "\n";
}

}  // namespace scslam
