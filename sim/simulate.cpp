// The loop: sweep after sweep into the rawlog, the truth beside it.
#include <chrono>
#include <fstream>
#include <future>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/log.h"
#include "scslam/core/progress.h"
#include "scslam/core/trajectory.h"
#include "sim/rawlog_writer.h"
#include "sim/render.h"
#include "sim/simulation.h"

namespace scslam::sim {

namespace fs = std::filesystem;

namespace {

/// Simulated drives begin here: 2026-01-01 00:00 UTC. [s]
constexpr double kEpoch = 1767225600;

/// Names of what lies beside OUT.rawlog.
struct Outputs {
  fs::path rawlog, stem;
  explicit Outputs(const fs::path& output) : rawlog(output), stem(output) {
    if (rawlog.extension() != ".rawlog") rawlog += ".rawlog";
    stem = rawlog;
    stem.replace_extension();
  }
  fs::path operator()(const char* suffix) const { return stem.string() + suffix; }
};

Stamp stampAt(double t) { return stampFromNanoseconds(std::llround((kEpoch + 0.0) * 1e9) + std::llround(t * 1e9)); }

void writeTruthPoses(const Simulation& simulation, const Outputs& out) {
  std::vector<double> times;
  for (std::uint32_t k = 0; k < simulation.scans(); ++k) times.push_back(simulation.sweepStart(k));
  for (double t = 0; t <= simulation.drive().duration(); t += 0.05) times.push_back(t);
  std::sort(times.begin(), times.end());
  std::vector<StampedPose> poses;
  for (const double t : times) {
    if (!poses.empty() && secondsBetween(poses.back().stamp, stampAt(t)) < 1e-4) continue;
    poses.push_back({stampAt(t), simulation.drive().pose(t)});
  }
  writeFileAtomically(out(".gt.tum"), formatTum(poses));
}

void writeFirings(Simulation& simulation, const Outputs& out) {
  const BeamGrid& grid = simulation.lidar().grid();
  std::ofstream file(out(".firings.tum"), std::ios::binary);
  for (std::uint32_t k = 0; k < simulation.scans(); ++k) {
    std::vector<StampedPose> poses;
    for (int c = 0; c < grid.columns(); ++c) {
      const double t = simulation.sweepStart(k) + grid.columnTime(c);
      poses.push_back({stampAt(t), simulation.drive().pose(t)});
    }
    file << formatTum(poses);
  }
  if (!file.flush()) throw inputError("cannot write {}", out(".firings.tum").string());
}

void writePlaces(Simulation& simulation, const Outputs& out, ThreadPool& threads, SimulationSummary& summary) {
  const TruthParams& truth = simulation.scenario().truth;
  if (!truth.loops && !truth.aliases) return;
  const SensorModel& sensor = simulation.lidar().sensor();
  const auto places = placesOf(simulation.drive(), sensor.T_base_sensor(), simulation.lidar().grid().sweep(),
                               simulation.scans(), truth.place_every_m);
  if (truth.loops) {
    const auto found = revisits(places, simulation.scene(), sensor.max_range_m, truth.min_travel_m, threads);
    summary.revisits = found.size();
    writeFileAtomically(out(".loops.csv"), revisitsCsv(places, found));
  }
  if (truth.aliases) {
    const auto found = aliases(places, simulation.scene(), sensor.max_range_m, threads);
    summary.aliases = found.size();
    writeFileAtomically(out(".aliases.csv"), aliasesCsv(places, found));
  }
}

void writePictures(Simulation& simulation, const Outputs& out, ThreadPool& threads) {
  if (!simulation.scenario().truth.pictures) return;
  const RayScene& scene = simulation.scene();
  const std::uint32_t middle = simulation.scans() / 3;
  writeFileAtomically(out(".world.png"),
                      renderTop(scene, simulation.world().mesh.bounds(), simulation.drive(), threads));
  for (std::uint32_t k = middle; k < simulation.scans(); ++k)
    if (const auto scan = simulation.sweep(k, threads)) {
      writeFileAtomically(out(".scan.png"), renderScan(*scan, simulation.lidar()));
      break;
    }
  writeFileAtomically(out(".oblique.png"),
                      renderOblique(scene, simulation.drive(), simulation.sweepStart(middle), threads));
}

/// How the log introduces itself; `scslam info` shows the first lines.
std::string introduction(const Simulation& simulation) {
  const Scenario& s = simulation.scenario();
  return fmt::format("scslam sim: scenario {}, seed {}, world {}, LiDAR {}\n{}", s.name, s.seed, s.world.kind.name,
                     s.lidar.sensor, dumpYaml(s));
}

void writeLabels(const LidarScan& scan, const Outputs& out, std::uint32_t number) {
  writeFileAtomically(out(".labels") / fmt::format("{:06}.label", number),
                      {reinterpret_cast<const char*>(scan.labels.data()), scan.labels.size() * 4});
}

}  // namespace

SimulationSummary simulate(const Scenario& scenario, const SimulateOptions& options, const PluginContext& context) {
  const Outputs out(options.output);
  if (fs::exists(out.rawlog) && !options.overwrite)
    throw usageError("{} exists: choose another -o, or -w to replace it", out.rawlog.string());
  if (out.rawlog.has_parent_path()) fs::create_directories(out.rawlog.parent_path());
  const auto begin = std::chrono::steady_clock::now();
  Simulation simulation(scenario, context);
  SimulationSummary summary;
  summary.triangles = simulation.world().mesh.size();
  summary.length_m = simulation.drive().length();
  summary.collision = simulation.collision();
  if (!summary.collision.empty()) logWarn(context.log, "{}", summary.collision);
  if (simulation.scans() == 0)
    throw usageError("the drive lasts {:.2f} s: shorter than one sweep", simulation.drive().duration());

  if (scenario.truth.labels) fs::create_directories(out(".labels"));
  RawlogWriter rawlog(out.rawlog, options.compression);
  rawlog.add(*asComment(introduction(simulation), stampAt(0)));
  Progress progress("simulating", simulation.scans(), options.quiet);
  std::future<void> writing;  // of the sweep before, while the next is traced
  for (std::uint32_t k = 0; k < simulation.scans(); ++k) {
    if (options.stop != nullptr && *options.stop) {
      summary.stopped = true;
      break;
    }
    auto scan = simulation.sweep(k, context.threads);
    if (writing.valid()) writing.get();
    progress.update(k + 1);
    if (!scan) continue;
    ++summary.scans;
    summary.points += scan->cloud.size();
    const Stamp stamp = stampAt(simulation.sweepStart(k) + scenario.faults.time_offset_s);
    writing = std::async(std::launch::async, [&, number = summary.scans - 1, stamp, taken = std::move(*scan)] {
      rawlog.add(*asObservation(taken, simulation.lidar(), stamp, "lidar"));
      if (scenario.truth.labels) writeLabels(taken, out, number);
    });
  }
  if (writing.valid()) writing.get();
  progress.finish();
  rawlog.finish();
  summary.rays = simulation.lidar().rays();
  summary.duration_s = simulation.drive().duration();
  writeFileAtomically(out(".yaml"), dumpYaml(scenario));
  writeTruthPoses(simulation, out);
  if (scenario.truth.firings) writeFirings(simulation, out);
  writePlaces(simulation, out, context.threads, summary);
  writePictures(simulation, out, context.threads);
  summary.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  summary.sha256 = sha256Of(out.rawlog);
  return summary;
}

}  // namespace scslam::sim
