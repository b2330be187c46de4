// scslam sim: a scenario becomes a rawlog with everything true about it beside.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "scslam/core/error.h"
#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "sim/simulation.h"
#include "verb.h"

namespace scslam::cli {
namespace {

struct Options {
  std::string scenario, output;
  std::vector<std::string> sets;
  int seed = 0, threads = 0;
  bool json = false, list = false, dump = false;
  sim::SimulateOptions job;
};

int listScenarios(bool json) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const auto& [name, summary] : sim::scenarioNames()) {
    all.push_back({{"name", name}, {"summary", summary}});
    if (!json) fmt::print("{:<22} {}\n", name, summary);
  }
  if (json) fmt::print("{}\n", all.dump());
  return 0;
}

void print(const sim::SimulationSummary& s, const sim::Scenario& scenario, const Options& options) {
  const double mrays = s.wall_s > 0 ? static_cast<double>(s.rays) / s.wall_s / 1e6 : 0;
  if (options.json) {
    const nlohmann::ordered_json json = {{"scenario", scenario.name},    {"scans", s.scans},
                                         {"radar_scans", s.radar_scans}, {"rays", s.rays},
                                         {"wall_s", s.wall_s},           {"mrays_per_s", mrays},
                                         {"points", s.points},           {"seed", scenario.seed},
                                         {"sha256", s.sha256},           {"duration_s", s.duration_s},
                                         {"length_m", s.length_m},       {"triangles", s.triangles},
                                         {"revisits", s.revisits},       {"aliases", s.aliases},
                                         {"collision", s.collision},     {"output", options.job.output.string()}};
    fmt::print("{}\n", json.dump());
    return;
  }
  fmt::print("{:<12} {} ({}), seed {}, {} triangles\n", "scenario", scenario.name, scenario.world.kind.name,
             scenario.seed, s.triangles);
  fmt::print("{:<12} {:.1f} s, {:.0f} m, {} pairs of revisited places, {} look-alikes\n", "drive", s.duration_s,
             s.length_m, s.revisits, s.aliases);
  fmt::print("{:<12} {} scans of {}, {:.1f} M points\n", "lidar", s.scans, scenario.lidar.sensor,
             static_cast<double>(s.points) / 1e6);
  if (s.radar_scans != 0) fmt::print("{:<12} {} scans of {}\n", "radar", s.radar_scans, scenario.radar.sensor);
  fmt::print("{:<12} {:.1f} s, {:.1f} M rays\n", "took", s.wall_s, static_cast<double>(s.rays) / 1e6);
  fmt::print("{:<12} {}\n", "sha256", s.sha256);
  fmt::print("{:<12} {}\n", "rawlog", options.job.output.string());
}

int simulateScenario(Options& options, const GlobalOptions& global) {
  if (options.list) return listScenarios(options.json);
  if (options.scenario.empty()) throw usageError("which scenario? `scslam sim --list` shows them; a YAML file will do");
  sim::Scenario scenario = sim::loadScenario(options.scenario, options.sets);
  if (options.seed > 0) scenario.seed = options.seed;
  if (options.dump) {
    fmt::print("{}", dumpYaml(scenario, true));
    return 0;
  }
  options.job.output = options.output.empty() ? scenario.name + ".rawlog" : options.output;
  if (options.job.output.extension() != ".rawlog") options.job.output += ".rawlog";
  options.job.quiet = global.quiet, options.job.stop = stopOnSignals();
  Log log(verbosity(global));
  ThreadPool threads(threadsOr(options.threads));
  const sim::SimulationSummary summary = sim::simulate(scenario, options.job, {threads, log});
  print(summary, scenario, options);
  return static_cast<int>(summary.stopped ? ExitCode::kStopped : ExitCode::kDone);
}

}  // namespace

Verb simVerb() {
  return {"sim", "simulate a scenario: rawlog, truth, labels, pictures", [](CLI::App& app) {
            auto options = std::make_shared<Options>();
            app.add_option("scenario", options->scenario, "shipped scenario (s01, s01_loop) or a YAML file")
                ->type_name("SCENARIO");
            app.add_option("-o,--output", options->output, "OUT.rawlog; the rest is named OUT.* (default: its name)");
            app.add_option("--seed", options->seed, "of everything random (default: the scenario's)")
                ->check(CLI::PositiveNumber);
            app.add_option("--set", options->sets, "change one key: drive.speed_mps=12")->allow_extra_args(false);
            app.add_option("--threads", options->threads, "threads (default: all); the result is the same");
            app.add_option("--compress", options->job.compression, "gzip level of the rawlog")
                ->check(CLI::Range(0, 9))
                ->capture_default_str();
            app.add_flag("-w,--overwrite", options->job.overwrite, "replace what is there");
            app.add_flag("--list", options->list, "the shipped scenarios");
            app.add_flag("--dump", options->dump, "the scenario with all its keys, explained, as YAML");
            app.add_flag("--json", options->json, "one JSON object on stdout");
            return [options](const GlobalOptions& global) { return simulateScenario(*options, global); };
          }};
}

}  // namespace scslam::cli
