// scslam compare: several front-ends over several inputs. Each run (and each simulation) is a process of its own: its
// memory and time are its own, and a crash is a row of the table, not the end of it.
#include <unistd.h>

#include <atomic>
#include <csignal>

#include "scslam/apps/compare.h"
#include "scslam/apps/compare_process.h"
#include "scslam/apps/run_job.h"
#include "scslam/core/file.h"
#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "scslam/view/trajectories_svg.h"
#include "sim/scenario.h"
#include "verb.h"

namespace scslam::cli {
namespace {

namespace fs = std::filesystem;

std::atomic<bool> stop_requested{false};
void requestStop(int) { stop_requested = true; }  // the child gets the signal, too, and ends by itself

struct CompareFlags {
  std::vector<std::string> inputs, scenarios, odometry, truths, configs, sets, sim_sets, plugins;
  std::string poses, sensor, label, output;
  std::size_t max = 0;
  int threads = 1, seed = 0;
  bool loops = true, no_loops = false, json = false, markdown = false;
};

struct Input {
  std::string label;
  fs::path path;
  std::optional<Trajectory> truth;     ///< T_truth_base
  std::vector<std::string> arguments;  ///< of `run`, for this input
  std::string odometry;                ///< the only one it can do with; empty: any
  std::string refusal;                 ///< why it cannot be run at all
};

/// Where sessions and simulated drives go: what the user named, or a folder that ends with this object.
class Workplace {
 public:
  explicit Workplace(const std::string& output) : kept_(!output.empty()) {
    folder_ = kept_ ? fs::path(output)
                    : fs::temp_directory_path() / fmt::format("scslam-compare-{}", static_cast<long>(getpid()));
    std::error_code error;
    fs::create_directories(folder_, error);
    if (error) throw inputError("cannot make folder {}: {}", folder_.string(), error.message());
  }
  ~Workplace() {
    std::error_code ignored;
    if (!kept_) fs::remove_all(folder_, ignored);
  }
  Workplace(const Workplace&) = delete;
  Workplace& operator=(const Workplace&) = delete;
  const fs::path& folder() const { return folder_; }
  bool kept() const { return kept_; }

 private:
  bool kept_;
  fs::path folder_;
};

fs::path thisProgram() { return fs::read_symlink("/proc/self/exe"); }

std::string stemOf(const fs::path& path) {
  return (path.filename().empty() ? path.parent_path() : path).stem().string();
}

Input openInput(const CompareFlags& flags, std::size_t i, const PluginContext& context) {
  Input input;
  input.path = flags.inputs[i];
  input.label = stemOf(input.path);
  const OpenedSource opened = openSource(input.path, context);
  if (flags.truths.empty())
    input.truth = opened.source->groundTruth();
  else
    input.truth = inBaseFrame(readTrajectory(flags.truths[i]), opened.source->T_base_reference());
  return input;
}

/// Simulates a scenario into `folder`, where it is not there already.
Input simulated(const CompareFlags& flags, const std::string& name, const fs::path& folder) {
  const sim::Scenario scenario = sim::loadScenario(name, flags.sim_sets);
  Input input;
  input.label = scenario.name;
  input.path = folder / (scenario.name + ".rawlog");
  if (!scenario.expect.slam) {
    input.refusal = "the scenario is not made for SLAM";
    return input;
  }
  std::vector<std::string> arguments = {"sim", name, "-o",    input.path.string(),
                                        "-w",  "-q", "--set", "truth.pictures=false"};
  for (const auto& set : flags.sim_sets) arguments.insert(arguments.end(), {"--set", set});
  if (flags.seed > 0) arguments.insert(arguments.end(), {"--seed", std::to_string(flags.seed)});
  const ProcessResult result = runProcess(thisProgram(), arguments, folder / (scenario.name + ".sim.log"));
  if (result.exit_code != 0) {
    input.refusal = fmt::format("simulation ended with {}: {}", result.exit_code, result.last_line);
    return input;
  }
  input.truth = readTrajectory(fs::path(input.path).replace_extension(".gt.tum"));
  if (!scenario.expect.config.empty()) input.arguments = {"-c", scenario.expect.config};
  input.odometry = scenario.expect.odometry;
  return input;
}

std::vector<std::string> runArguments(const CompareFlags& flags, const Input& input, const std::string& frontend,
                                      const fs::path& session) {
  std::vector<std::string> arguments = {
      "run",       input.path.string(),          "-o", session.string(), "-w", "-q", "--odometry", frontend, "--json",
      "--threads", std::to_string(flags.threads)};
  const auto add = [&](const char* flag, const std::string& value) {
    if (!value.empty()) arguments.insert(arguments.end(), {flag, value});
  };
  arguments.insert(arguments.end(), input.arguments.begin(), input.arguments.end());
  for (const auto& config : flags.configs) add("-c", config);
  for (const auto& set : flags.sets) add("--set", set);
  for (const auto& plugin : flags.plugins) add("--plugin", plugin);
  if (!flags.loops) add("--set", "place.recognisers=[]");
  add("--poses", flags.poses);
  add("--sensor", flags.sensor);
  add("--label", flags.label);
  if (flags.max > 0) add("--max", std::to_string(flags.max));
  return arguments;
}

/// "exit 4: the input ended early …", without the words that every message begins with.
std::string failureOf(const ProcessResult& result) {
  if (result.exit_code == 0) return {};
  std::string line = result.last_line;
  for (const char* lead : {"error: ", "warning: "})
    if (line.starts_with(lead)) line.erase(0, std::string_view(lead).size());
  if (result.exit_code > 128 && result.exit_code != static_cast<int>(ExitCode::kStopped))
    return fmt::format("crashed (signal {})", result.exit_code - 128);
  return fmt::format("exit {}: {}", result.exit_code, line);
}

ComparedRun runOne(const CompareFlags& flags, const Input& input, const std::string& frontend, const fs::path& folder) {
  ComparedRun run;
  run.input = input.label, run.frontend = frontend, run.with_loops = flags.loops;
  run.failure = input.refusal;
  if (run.failure.empty() && !input.odometry.empty() && input.odometry != frontend)
    run.failure = fmt::format("the scenario is made for {}", input.odometry);
  if (!run.failure.empty()) return run;
  const fs::path session = folder / fmt::format("{}.{}.session", input.label, frontend);
  const ProcessResult result = runProcess(thisProgram(), runArguments(flags, input, frontend, session),
                                          folder / fmt::format("{}.{}.log", input.label, frontend));
  run.failure = failureOf(result);
  const bool made = result.exit_code == 0 || result.exit_code == static_cast<int>(ExitCode::kEndedEarly);
  if (!made) return run;
  try {
    readRun(run, session, input.truth);
  } catch (const Error& error) {
    run.failure = error.what();
  }
  if (run.scans > 0) run.cpu_ms_per_scan = 1e3 * result.cpu_s / static_cast<double>(run.scans);
  return run;
}

void check(CompareFlags& flags) {
  if (flags.inputs.empty() && flags.scenarios.empty())
    throw usageError("compare what? Give INPUT…, or --scenarios (scslam sim --list)");
  if (!flags.truths.empty() && flags.truths.size() != flags.inputs.size())
    throw usageError("--gt: {} files for {} inputs; give one for each, in order, or none", flags.truths.size(),
                     flags.inputs.size());
  const auto& frontends = Registry<Odometry>::instance();
  if (flags.odometry.empty()) flags.odometry = frontends.names();
  for (const auto& frontend : flags.odometry) frontends.find(frontend);
  for (const auto& scenario : flags.scenarios) sim::loadScenario(scenario, flags.sim_sets);
}

void makeUnique(std::vector<Input>& inputs) {
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    std::size_t same = 1;
    for (std::size_t j = 0; j < i; ++j) same += inputs[j].path.stem() == inputs[i].path.stem();
    if (same > 1) inputs[i].label += fmt::format(" ({})", same);
  }
}

int run(CompareFlags flags, const GlobalOptions& global) {
  Log log(verbosity(global));
  if (flags.json && flags.markdown) throw usageError("--json and --markdown: stdout takes one of them");
  flags.loops = !flags.no_loops;
  for (const auto& plugin : flags.plugins) loadPlugin(plugin);
  check(flags);
  std::signal(SIGINT, requestStop);
  std::signal(SIGTERM, requestStop);
  const Workplace workplace(flags.output);
  ThreadPool threads(1);
  std::vector<Input> inputs;
  for (std::size_t i = 0; i < flags.inputs.size(); ++i) inputs.push_back(openInput(flags, i, {threads, log}));
  for (std::size_t i = 0; i < flags.scenarios.size() && !stop_requested; ++i) {
    logInfo(log, "simulating {} ({} of {})", flags.scenarios[i], i + 1, flags.scenarios.size());
    inputs.push_back(simulated(flags, flags.scenarios[i], workplace.folder()));
  }
  makeUnique(inputs);

  std::vector<ComparedRun> runs;
  for (const Input& input : inputs)
    for (const auto& frontend : flags.odometry) {
      if (stop_requested) return static_cast<int>(ExitCode::kStopped);
      logInfo(log, "{}: {}", input.label, frontend);
      runs.push_back(runOne(flags, input, frontend, workplace.folder()));
    }
  if (stop_requested) return static_cast<int>(ExitCode::kStopped);

  if (workplace.kept()) {
    writeFileAtomically(workplace.folder() / "compare.json", compareJson(runs));
    writeFileAtomically(workplace.folder() / "compare.md", compareMarkdown(runs));
    writeFileAtomically(workplace.folder() / "compare.svg", trajectoriesSvg(runs));
  }
  fmt::print("{}", flags.json ? compareJson(runs) : flags.markdown ? compareMarkdown(runs) : compareTable(runs));
  if (workplace.kept() && !flags.json && !flags.markdown)
    fmt::print("written: {0}/compare.svg, compare.md, compare.json; sessions and logs beside them\n",
               workplace.folder().string());
  const bool any = std::any_of(runs.begin(), runs.end(), [](const ComparedRun& r) { return r.session.has_value(); });
  return static_cast<int>(any ? ExitCode::kDone : ExitCode::kInput);
}

}  // namespace

Verb compareVerb() {
  return {
      "compare", "several front-ends over the same inputs: one table, all trajectories", [](CLI::App& app) {
        auto flags = std::make_shared<CompareFlags>();
        app.add_option("INPUT", flags->inputs, "one or several, as `run` takes them");
        app.add_option("--scenarios", flags->scenarios, "simulate these first: s01,s02 (scslam sim --list)")
            ->delimiter(',');
        app.add_option("--odometry", flags->odometry, "front-ends, separated by commas (default: all)")->delimiter(',');
        app.add_option("--gt", flags->truths,
                       "true trajectory (TUM or KITTI), one for each INPUT in order (default: the inputs' own)")
            ->allow_extra_args(false);
        auto* loops = app.add_flag("--loops", flags->loops, "look for loops (default): figures before and after");
        app.add_flag("--no-loops", flags->no_loops, "odometry alone")->excludes(loops);
        app.add_option("-o,--output", flags->output,
                       "keep everything here: compare.svg, compare.md, compare.json, sessions, logs");
        app.add_option("-c,--config", flags->configs, "configuration: file or shipped name")->allow_extra_args(false);
        app.add_option("--set", flags->sets, "one parameter: section.key=value")->allow_extra_args(false);
        app.add_option("--sim-set", flags->sim_sets, "one key of the scenarios: drive.duration_s=20")
            ->allow_extra_args(false);
        app.add_option("--seed", flags->seed, "of the simulation (default: the scenarios')")
            ->check(CLI::PositiveNumber);
        app.add_option("--poses", flags->poses, "trajectory for the front-end `poses`");
        app.add_option("--sensor", flags->sensor, "sensor table: file or shipped name");
        app.add_option("--label", flags->label, "take the scans of this sensor label");
        app.add_option("--max", flags->max, "take at most N scans of each input");
        app.add_option("--threads", flags->threads, "threads of each run (times are comparable with the default, 1)")
            ->check(CLI::PositiveNumber)
            ->capture_default_str();
        app.add_option("--plugin", flags->plugins, "load a library with front-ends of your own")
            ->allow_extra_args(false);
        app.add_flag("--json", flags->json, "print one JSON object on stdout and nothing else");
        app.add_flag("--markdown", flags->markdown, "print the table as Markdown");
        return [flags](const GlobalOptions& global) { return run(*flags, global); };
      }};
}

}  // namespace scslam::cli
