// scslam realism: how near are scans, simulated or recorded, to what a real sensor gives?
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "scslam/core/progress.h"
#include "scslam/core/suggest.h"
#include "scslam/sensor/scan_source.h"
#include "scslam/sensor/sensor_tables.h"
#include "sim/embedded_targets.h"
#include "sim/realism.h"
#include "sim/realism_score.h"
#include "verb.h"

namespace scslam::cli {
namespace {

using Json = nlohmann::ordered_json;
using sim::RealismMeter;
using sim::RealismTarget;

struct Options {
  std::string input, like, sensor, label, save;
  int max_scans = 0;
  bool json = false;
};

/// What was read and measured.
struct Measurement {
  std::string format, damage;  ///< damage: why reading ended early
  RealismTarget target;
  bool target_guessed = false;
  std::unique_ptr<RealismMeter> meter;
  sim::RealismFigures figures;
};

std::vector<RealismTarget> shippedTargets() {
  std::vector<RealismTarget> targets;
  for (const auto& [name, text] : sim::embeddedTargets()) targets.push_back(sim::loadRealismTarget(text, name));
  return targets;
}

RealismTarget targetNamed(const std::string& name_or_file) {
  const auto& shipped = sim::embeddedTargets();
  if (const auto it = shipped.find(name_or_file); it != shipped.end())
    return sim::loadRealismTarget(it->second, it->first);
  if (std::filesystem::is_regular_file(name_or_file))
    return sim::loadRealismTarget(readFile(name_or_file, std::size_t{1} << 20), name_or_file);
  std::vector<std::string> names;
  for (const auto& [name, text] : shipped) names.push_back(name);
  throw usageError("no real set (nor file) is called '{}'{}", name_or_file, didYouMean(name_or_file, names));
}

/// The shipped set on whose rings most of the scan lies.
RealismTarget targetFor(const Cloud& cloud) {
  const auto off = [&cloud](const RealismTarget& target) {
    RealismMeter meter(target.sensor);
    try {
      if (!meter.add(cloud)) return 1e9;
    } catch (const Error&) {
      return 1e9;  // more rings than this sensor has
    }
    const auto figures = meter.figures();
    return (1 - figures.on_ring_share) + std::fmin(1.0, figures.elevation_off_deg);
  };
  const std::vector<RealismTarget> targets = shippedTargets();
  if (targets.empty()) throw usageError("this build carries no real set; give one with --like FILE");
  std::vector<double> distance;
  for (const RealismTarget& target : targets) distance.push_back(off(target));
  return targets[static_cast<std::size_t>(std::min_element(distance.begin(), distance.end()) - distance.begin())];
}

Measurement measure(const Options& options, const GlobalOptions& global, Log& log) {
  ThreadPool threads(1);
  OpenOptions open;
  open.label = options.label;
  if (!options.sensor.empty()) open.sensor = loadSensorModel(options.sensor);
  Measurement m;
  if (!options.like.empty()) m.target = targetNamed(options.like);
  auto [source, format, why] = openSource(options.input, {threads, log}, open);
  if (source->planar()) throw inputError("{}: planar scans have no rings to compare", options.input);
  m.format = format;
  Progress progress("measuring", source->size(), global.quiet);
  try {
    for (int n = 0; options.max_scans == 0 || n < options.max_scans; ++n) {
      const auto scan = source->next();
      if (!scan) break;
      if (!m.meter) {
        m.target_guessed = options.like.empty();
        if (m.target_guessed) m.target = targetFor(scan->cloud);
        m.meter = std::make_unique<RealismMeter>(open.sensor.value_or(m.target.sensor));
      }
      m.meter->add(scan->cloud);
      progress.update(static_cast<std::size_t>(n) + 1);
    }
  } catch (const Error& error) {
    if (!m.meter || m.meter->scans() == 0) throw;
    m.damage = error.what();
  }
  progress.finish();
  if (!m.meter || m.meter->scans() == 0)
    throw inputError("{}: no scan with points on the rings of a sensor table; --sensor names another", options.input);
  m.figures = m.meter->figures();
  return m;
}

Json numberOrNull(double value) { return sim::measured(value) ? Json(value) : Json(nullptr); }

Json valueOf(const sim::NamedFigure& figure) {
  if (!figure.list) return numberOrNull(figure.values.front());
  Json list = Json::array();
  for (const double value : figure.values) list.push_back(numberOrNull(value));
  return list;
}

Json toJson(const Options& options, const Measurement& m, const std::vector<sim::Score>& scores) {
  Json json = {{"input", options.input},
               {"format", m.format},
               {"scans", m.meter->scans()},
               {"scans_without_points_on_rings", m.meter->skipped()},
               {"sensor", m.meter->sensor().name},
               {"rings", m.meter->ringSource()},
               {"like", m.target.name},
               {"like_guessed", m.target_guessed},
               {"like_about", m.target.about}};
  if (!m.meter->whyNoSignal().empty()) json["no_signal"] = m.meter->whyNoSignal();
  if (!m.damage.empty()) json["ended_early"] = m.damage;
  const auto input = sim::namedFigures(m.figures), target = sim::namedFigures(m.target.figures);
  for (std::size_t i = 0; i < input.size(); ++i)
    json["figures"][input[i].key] = {{"input", valueOf(input[i])}, {"target", valueOf(target[i])}};
  for (const sim::Score& score : scores)
    json["scores"].push_back({{"name", score.name},
                              {"value", score.value ? Json(*score.value) : Json(nullptr)},
                              {"goal", score.goal},
                              {"note", score.note}});
  return json;
}

std::string text(double value) { return sim::measured(value) ? fmt::format("{:.5g}", value) : "-"; }

/// A short list as it is; of one entry a ring, the least, the mean and the greatest.
std::string text(const std::vector<double>& values) {
  if (values.empty()) return "-";
  std::string line;
  if (values.size() <= 20) {
    for (const double value : values) line += fmt::format("{:>11}", text(value));
    return line;
  }
  std::vector<double> known;
  std::copy_if(values.begin(), values.end(), std::back_inserter(known), sim::measured);
  if (known.empty()) return "-";
  const auto [lo, hi] = std::minmax_element(known.begin(), known.end());
  const double mean = std::accumulate(known.begin(), known.end(), 0.0) / static_cast<double>(known.size());
  return fmt::format("{} entries from {} to {}, mean {}", values.size(), text(*lo), text(*hi), text(mean));
}

void printTable(const Options& options, const Measurement& m, const std::vector<sim::Score>& scores) {
  fmt::print("input     {} ({}), {} scans, rings {}\n", options.input, m.format, m.meter->scans(),
             m.meter->ringSource());
  fmt::print("sensor    {}\n", m.meter->sensor().name);
  fmt::print("target    {}{}: {}\n", m.target.name, m.target_guessed ? " (its rings fit best)" : "", m.target.about);
  if (!m.meter->whyNoSignal().empty()) fmt::print("signal    left out: {}\n", m.meter->whyNoSignal());
  if (m.meter->skipped() != 0) fmt::print("skipped   {} scans without a point on a ring\n", m.meter->skipped());
  fmt::print("\n{:<30}{:>12}{:>12}\n", "figure", "input", "target");
  const auto input = sim::namedFigures(m.figures), target = sim::namedFigures(m.target.figures);
  for (std::size_t i = 0; i < input.size(); ++i)
    if (!input[i].list)
      fmt::print("{:<30}{:>12}{:>12}\n", input[i].key, text(input[i].values.front()), text(target[i].values.front()));
  for (std::size_t i = 0; i < input.size(); ++i)
    if (input[i].list)
      fmt::print("{:<30}input  {}\n{:<30}target {}\n", input[i].key, text(input[i].values), "", text(target[i].values));
  fmt::print("\n{:<18}{:>7}{:>7}\n", "score", "value", "goal");
  for (const sim::Score& score : scores)
    fmt::print("{:<18}{:>7}{:>7}  {}\n", score.name, score.value ? fmt::format("{:.3f}", *score.value) : "none",
               score.goal, score.note);
}

/// The figures of these scans as a target for others. @param options save: the file.
void saveTarget(const Options& options, const Measurement& m) {
  RealismTarget target = m.target;
  target.name = std::filesystem::path(options.save).stem().string();
  target.about = fmt::format("{}, {} scans", options.input, m.meter->scans());
  target.sensor = m.meter->sensor();
  target.figures = m.figures;
  writeFileAtomically(options.save, "# Figures of scans, for scslam realism --like\n" + sim::targetYaml(target));
}

int realism(const Options& options, const GlobalOptions& global) {
  Log log(verbosity(global));
  const Measurement m = measure(options, global, log);
  if (m.figures.on_ring_share < 0.95)
    logWarn(log, "only {:.0f} % of the returns lie on the rings of '{}'; is that the sensor? (--sensor, --like)",
            100 * m.figures.on_ring_share, m.meter->sensor().name);
  if (!m.damage.empty()) logWarn(log, "reading ended early: {}", m.damage);
  const auto scores = sim::scoreRealism(m.figures, m.meter->sensor(), m.target, shippedTargets());
  if (options.json)
    fmt::print("{}\n", toJson(options, m, scores).dump());
  else
    printTable(options, m, scores);
  if (!options.save.empty()) saveTarget(options, m);
  return static_cast<int>(m.damage.empty() ? ExitCode::kDone : ExitCode::kEndedEarly);
}

}  // namespace

Verb realismVerb() {
  return {"realism", "how near scans are to those of a real sensor: figures and six scores", [](CLI::App& app) {
            auto options = std::make_shared<Options>();
            app.add_option("input", options->input, "rawlog, scan folder, session or cloud file")
                ->required()
                ->type_name("X");
            app.add_option("--like", options->like,
                           "real set to compare with: kaist03_os1-64, seosan01_os1-128 or a YAML file (default: the "
                           "one whose rings fit)");
            app.add_option("--sensor", options->sensor,
                           "sensor table of the input: a shipped name or a YAML file (default: that of the real set)");
            app.add_option("--label", options->label, "sensor label in a rawlog (default: the first with scans)");
            app.add_option("--max", options->max_scans, "measure only the first N scans")
                ->type_name("N")
                ->check(CLI::PositiveNumber);
            app.add_option("--save", options->save, "write the figures as a real set of their own (YAML)")
                ->type_name("FILE");
            app.add_flag("--json", options->json, "one JSON object on stdout");
            return [options](const GlobalOptions& global) { return realism(*options, global); };
          }};
}

}  // namespace scslam::cli
