// scslam info: what is this input, and what would be read from it?
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "scslam/core/error.h"
#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "scslam/core/progress.h"
#include "scslam/graph/g2o.h"
#include "scslam/sensor/scan_source.h"
#include "scslam/sensor/sensor_tables.h"
#include "verb.h"

namespace scslam::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  std::string input, label, sensor;
  bool scan = false, json = false;
};

std::string fieldsOf(const Cloud& cloud) {
  std::string fields = "x y z";
  if (cloud.hasIntensity()) fields += " intensity";
  if (cloud.hasTime()) fields += " dt";
  if (cloud.hasRing()) fields += " ring";
  return fields;
}

/// [s] from the earliest to the latest point; 0 without times.
double sweepOf(const Cloud& cloud) {
  if (cloud.dt.empty()) return 0;
  const auto [first, last] = std::minmax_element(cloud.dt.begin(), cloud.dt.end());
  return static_cast<double>(*last) - static_cast<double>(*first);
}

double lengthOf(const Trajectory& trajectory) {
  double length = 0;
  for (std::size_t i = 1; i < trajectory.poses.size(); ++i)
    length += (trajectory.poses[i].T.translation() - trajectory.poses[i - 1].T.translation()).norm();
  return length;
}

/// What reading every scan shows.
struct Survey {
  std::size_t scans = 0, empty = 0, with_odometry = 0, backward = 0;
  std::size_t least_points = 0, most_points = 0;
  double points = 0, longest_gap_s = 0;
  Stamp first, last;
  std::string damage;  ///< why reading ended early

  void add(const Scan& scan) {
    const std::size_t n = scan.cloud.size();
    if (scans == 0) first = scan.stamp, least_points = n;
    if (scans != 0) {
      const double step = secondsBetween(last, scan.stamp);
      backward += step <= 0;
      longest_gap_s = std::max(longest_gap_s, step);
    }
    last = scan.stamp;
    ++scans;
    empty += n == 0;
    with_odometry += scan.T_odom_base.has_value();
    points += static_cast<double>(n);
    least_points = std::min(least_points, n), most_points = std::max(most_points, n);
  }
};

Json toJson(const Pose& T) {
  Json rows = Json::array();
  for (int i = 0; i < 12; ++i) rows.push_back(T.matrix()(i / 4, i % 4));
  return rows;
}

Json describeFirst(const Scan& scan) {
  return {{"points", scan.cloud.size()},
          {"fields", fieldsOf(scan.cloud)},
          {"stamp", formatStamp(scan.stamp)},
          {"sweep_s", sweepOf(scan.cloud)},
          {"sensor", scan.label},
          {"T_base_sensor", toJson(scan.T_base_sensor)},
          {"deskewed", scan.deskewed},
          {"odometry", scan.T_odom_base.has_value()}};
}

Json describeSurvey(const Survey& survey) {
  Json json = {{"scans", survey.scans},
               {"empty_scans", survey.empty},
               {"scans_with_odometry", survey.with_odometry},
               {"first_stamp", formatStamp(survey.first)},
               {"last_stamp", formatStamp(survey.last)},
               {"duration_s", survey.scans != 0 ? secondsBetween(survey.first, survey.last) : 0.0},
               {"longest_gap_s", survey.longest_gap_s},
               {"stamps_not_increasing", survey.backward},
               {"points_min", survey.least_points},
               {"points_mean", survey.scans != 0 ? survey.points / static_cast<double>(survey.scans) : 0.0},
               {"points_max", survey.most_points}};
  if (!survey.damage.empty()) json["ended_early"] = survey.damage;
  return json;
}

Json describeSource(const Options& options, Log& log, const GlobalOptions& global) {
  ThreadPool threads(1);
  OpenOptions open;
  open.label = options.label;
  if (!options.sensor.empty()) open.sensor = loadSensorModel(options.sensor);
  auto [source, format, why] = openSource(options.input, {threads, log}, open);
  Json json = {{"input", options.input}, {"format", format}, {"why", why}};
  if (const auto size = source->size()) json["scans"] = *size;
  json["planar"] = source->planar();
  Survey survey;
  if (const auto first = source->next()) {
    json["first_scan"] = describeFirst(*first);
    survey.add(*first);
  }
  if (options.scan) {
    Progress progress("reading", source->size(), global.quiet);
    try {
      while (const auto scan = source->next()) {
        survey.add(*scan);
        progress.update(survey.scans);
      }
    } catch (const Error& error) {
      survey.damage = error.what();
    }
    progress.finish();
    json["survey"] = describeSurvey(survey);
  }
  if (const auto truth = source->groundTruth())
    json["ground_truth"] = {{"poses", truth->poses.size()}, {"length_m", lengthOf(*truth)}};
  else
    json["ground_truth"] = nullptr;
  json["description"] = source->description();  // last: it tells what came to light while reading
  return json;
}

Json describeGraph(const Options& options, Log& log) {
  const G2oFile file = readG2o(options.input);
  for (const std::string& warning : file.warnings) logWarn(log, "{}", warning);
  const auto loops = std::count_if(file.graph.factors.begin(), file.graph.factors.end(),
                                   [](const Factor& factor) { return factor.kind == FactorKind::kLoop; });
  return {{"input", options.input},
          {"format", "g2o"},
          {"why", "named .g2o"},
          {"poses", file.graph.poses.size()},
          {"edges", file.graph.factors.size()},
          {"loop_edges", loops},
          {"planar", file.graph.planar},
          {"poses_known", file.poses_known}};
}

/// The JSON as an indented list: what people and programs are told is the same.
void printTable(const Json& json, const std::string& indent = "") {
  for (const auto& [key, value] : json.items()) {
    if (value.is_object()) {
      fmt::print("{}{}\n", indent, key);
      printTable(value, indent + "  ");
    } else if (value.is_array()) {
      std::string numbers;
      for (const auto& number : value) numbers += fmt::format(" {:.6g}", number.get<double>());
      fmt::print("{}{:<{}}{}\n", indent, key, 22 - indent.size(), numbers);
    } else {
      const std::string text = value.is_string()         ? value.get<std::string>()
                               : value.is_null()         ? "none"
                               : value.is_boolean()      ? (value.get<bool>() ? "yes" : "no")
                               : value.is_number_float() ? fmt::format("{:.6g}", value.get<double>())
                                                         : value.dump();
      fmt::print("{}{:<{}} {}\n", indent, key, 22 - indent.size(), text);
    }
  }
}

int info(const Options& options, const GlobalOptions& global) {
  Log log(verbosity(global));
  const bool graph = options.input.ends_with(".g2o");
  const Json json = graph ? describeGraph(options, log) : describeSource(options, log, global);
  if (options.json)
    fmt::print("{}\n", json.dump());
  else
    printTable(json);
  const bool damaged = json.contains("survey") && json["survey"].contains("ended_early");
  return static_cast<int>(damaged ? ExitCode::kEndedEarly : ExitCode::kDone);
}

}  // namespace

Verb infoVerb() {
  return {"info", "what is in an input: format, scans, sensor, poses", [](CLI::App& app) {
            auto options = std::make_shared<Options>();
            app.add_option("input", options->input, "rawlog, scan folder, session, cloud file or .g2o graph")
                ->required()
                ->type_name("X");
            app.add_flag("--scan", options->scan, "read every scan: count, times, gaps, damage");
            app.add_option("--label", options->label, "sensor label in a rawlog (default: the first with scans)");
            app.add_option("--sensor", options->sensor, "sensor table: a shipped name or a YAML file");
            app.add_flag("--json", options->json, "one JSON object on stdout");
            return [options](const GlobalOptions& global) { return info(*options, global); };
          }};
}

}  // namespace scslam::cli
