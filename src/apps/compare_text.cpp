#include <algorithm>
#include <nlohmann/json.hpp>

#include "scslam/apps/compare.h"

namespace scslam {
namespace {

using Row = std::vector<std::string>;
using Json = nlohmann::ordered_json;

const Row kHead = {"input", "odometry", "ATE odometry [m]", "ATE [m]", "RPE odometry [%]", "RPE [%]", "RPE [deg/m]",
                   "loops", "NEES",     "ms/scan",          "CPU ms",  "x real time",      "MB",      "failures"};

/// "7.2 (5.8 … 6.2)": the mean and the band it belongs in.
std::string neesText(const StepConsistency& s) {
  if (!s.mean) return s.singular > 0 ? "singular" : "-";
  const char* verdict = *s.mean > s.high ? " over-confident" : *s.mean < s.low ? " pessimistic" : " honest";
  return fmt::format("{:.3g} ({:.2f} … {:.2f}){}", *s.mean, s.low, s.high, verdict);
}

std::string loopsText(const ComparedRun& run) {
  if (!run.with_loops) return "off";
  if (!run.evaluation) return std::to_string(run.loops);
  const LoopFigures& f = run.evaluation->loops;
  std::string text = fmt::format("{} true, {} false", f.true_accepted, f.false_accepted);
  if (f.recall) text += fmt::format(", recall {:.2f}", *f.recall);
  return text;
}

std::string failureText(const ComparedRun& run) {
  std::string text = run.failure;
  if (run.lost_scans > 0) text += fmt::format("{}{} scans lost", text.empty() ? "" : "; ", run.lost_scans);
  if (run.steps.singular > 0 && run.steps.mean)
    text += fmt::format("{}{} singular covariances", text.empty() ? "" : "; ", run.steps.singular);
  return text.empty() ? "none" : text;
}

Row cells(const ComparedRun& run) {
  if (!run.session) {
    Row row(kHead.size(), "-");
    row[0] = run.input, row[1] = run.frontend, row.back() = failureText(run);
    return row;
  }
  Row row = {run.input, run.frontend};
  const auto figure = [&](double value, bool known) { row.push_back(known ? fmt::format("{:.3f}", value) : "-"); };
  const bool truth = run.evaluation.has_value(), loops = truth && run.with_loops;
  const Evaluation e = run.evaluation.value_or(Evaluation());
  figure(e.odometry_ate.rmse_m, truth), figure(e.ate.rmse_m, loops);
  figure(e.odometry_rpe.trans_percent, truth && e.odometry_rpe.segments > 0);
  figure(e.rpe.trans_percent, loops && e.rpe.segments > 0);
  figure((loops ? e.rpe : e.odometry_rpe).rot_deg_per_m, truth && e.rpe.segments > 0);
  row.push_back(loopsText(run));
  row.push_back(truth ? neesText(run.steps) : "-");
  row.push_back(fmt::format("{:.1f}", run.ms_per_scan));
  row.push_back(fmt::format("{:.1f}", run.cpu_ms_per_scan));
  row.push_back(fmt::format("{:.1f}", run.realtime_factor));
  row.push_back(fmt::format("{:.0f}", run.peak_rss_mb));
  row.push_back(failureText(run));
  return row;
}

/// Text of a Markdown cell.
std::string escaped(const std::string& cell) {
  std::string text;
  for (const char c : cell) {
    if (c == '|') text += '\\';
    text += c;
  }
  return text;
}

/// Characters as a terminal counts them (UTF-8 continuation bytes take no place).
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string render(const std::vector<Row>& rows, const std::string& before, const std::string& between,
                   const std::string& after) {
  std::vector<std::size_t> widths(kHead.size(), 0);
  for (const Row& row : rows)
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], width(row[c]));
  std::string text;
  for (const Row& row : rows) {
    text += before;
    for (std::size_t c = 0; c < row.size(); ++c) {
      const bool last = c + 1 == row.size();
      text += row[c];
      if (!last || !after.empty()) text += std::string(widths[c] - width(row[c]), ' ');
      if (!last) text += between;
    }
    text += after + "\n";
  }
  return text;
}

Json consistencyJson(const StepConsistency& s) {
  return {{"mean", s.mean ? Json(*s.mean) : Json(nullptr)},
          {"band_95", {s.low, s.high}},
          {"inside_95", s.inside_95 ? Json(*s.inside_95) : Json(nullptr)},
          {"axis_ratio", s.axis_ratio},
          {"dimensions", s.dimensions},
          {"steps", s.steps},
          {"singular", s.singular}};
}

}  // namespace

std::string compareTable(const std::vector<ComparedRun>& runs) {
  std::vector<Row> rows = {kHead};
  for (const ComparedRun& run : runs) rows.push_back(cells(run));
  return render(rows, "", "  ", "");
}

std::string compareMarkdown(const std::vector<ComparedRun>& runs) {
  std::vector<Row> rows = {kHead, Row(kHead.size(), "---")};
  for (const ComparedRun& run : runs) {
    rows.push_back(cells(run));
    for (std::string& cell : rows.back()) cell = escaped(cell);
  }
  return render(rows, "| ", " | ", " |");
}

std::string compareJson(const std::vector<ComparedRun>& runs) {
  Json all = Json::array();
  for (const ComparedRun& run : runs) {
    Json json = {{"input", run.input},
                 {"odometry", run.frontend},
                 {"failure", run.failure.empty() ? Json(nullptr) : Json(run.failure)},
                 {"with_loops", run.with_loops}};
    if (run.session) {
      json["scans"] = run.scans;
      json["keyframes"] = run.keyframes;
      json["lost_scans"] = run.lost_scans;
      json["loops_accepted"] = run.loops;
      json["ms_per_scan"] = run.ms_per_scan;
      json["odometry_ms_per_scan"] = run.odometry_ms_per_scan;
      json["cpu_ms_per_scan"] = run.cpu_ms_per_scan;
      json["realtime_factor"] = run.realtime_factor;
      json["peak_rss_mb"] = run.peak_rss_mb;
    }
    if (run.evaluation) {
      json.update(Json::parse(evaluationJson(*run.evaluation)));
      json["step_nees"] = consistencyJson(run.steps);
    }
    all.push_back(std::move(json));
  }
  return Json{{"runs", std::move(all)}}.dump(2) + "\n";
}

}  // namespace scslam
