// The loop: sweep after sweep into the rawlog, in order of time, the truth beside it.
#include <algorithm>
#include <chrono>
#include <future>
#include <memory>
#include <utility>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/log.h"
#include "scslam/core/progress.h"
#include "scslam/sensor/oxford_radar.h"
#include "scslam/sensor/radar_observation.h"
#include "sim/outputs.h"
#include "sim/rawlog_writer.h"

namespace scslam::sim {

namespace fs = std::filesystem;
using Observations = std::vector<mrpt::obs::CObservation::Ptr>;

namespace {

/// How the log introduces itself; `scslam info` shows the first line.
std::string introduction(const Scenario& s) {
  std::string sensors;
  const auto add = [&sensors](bool on, const std::string& name) {
    if (on) sensors += (sensors.empty() ? "" : ", ") + name;
  };
  add(s.lidar.on, s.lidar.sensor), add(s.radar.on, s.radar.sensor), add(s.imu.enabled, "imu");
  add(s.wheels.enabled, "wheels"), add(s.gnss.enabled, "gnss");
  return fmt::format("simulated: scenario {}, world {}, seed {}, sensors {}\n{}", s.name, s.world.kind.name, s.seed,
                     sensors, dumpYaml(s));
}

/// Sensors that sample on their own clocks.
class Navigation {
 public:
  Navigation(const Scenario& s, const Trajectory& drive, const RayScene& scene)
      : faults_(s.faults),
        imu_(s.imu, drive, static_cast<std::uint64_t>(s.seed), stampAt(0)),
        wheels_(s.wheels, drive, static_cast<std::uint64_t>(s.seed), stampAt(0)),
        gnss_(s.gnss, drive, static_cast<std::uint64_t>(s.seed), stampAt(0), &scene) {}
  /// What they measured since the last call, in order of time.
  Observations upTo(double t) {
    Observations all;
    const auto keep = [&](const mrpt::obs::CObservation::Ptr& observation) {
      if (!faults_.off(toSeconds(observation->timestamp) - toSeconds(stampAt(0)))) all.push_back(observation);
    };
    imu_.upTo(t, keep), wheels_.upTo(t, keep), gnss_.upTo(t, keep);
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a->timestamp < b->timestamp; });
    return all;
  }

 private:
  const FaultParams& faults_;
  Imu imu_;
  WheelOdometry wheels_;
  Gnss gnss_;
};

/// One simulation being written down.
class Recording {
 public:
  Recording(Simulation& simulation, const Outputs& out, int compression, ThreadPool& threads)
      : simulation_(simulation),
        out_(out),
        threads_(threads),
        rawlog_(out.rawlog, compression),
        navigation_(simulation.scenario(), simulation.drive(), simulation.scene()) {
    const Scenario& scenario = simulation.scenario();
    if (scenario.truth.labels) fs::create_directories(out_(".labels"));
    if (scenario.radar.on && scenario.radar.png) fs::create_directories(out_(".radar"));
    rawlog_.add(*asComment(introduction(scenario), stampAt(0)));
  }

  void lidarSweep(std::uint32_t number, SimulationSummary& summary) {
    const double start = simulation_.sweepStart(number);
    LidarScan scan = simulation_.sweep(number, threads_);
    const std::uint32_t index = summary.scans++;
    summary.points += scan.cloud.size();
    const Stamp stamp = stampAt(start + simulation_.scenario().faults.time_offset_s);
    write(navigation_.upTo(start), [this, index, stamp, taken = std::move(scan)] {
      rawlog_.add(*asObservation(taken, simulation_.lidar(), stamp, "lidar"));
      if (simulation_.scenario().truth.labels)
        writeFileAtomically(out_(".labels") / fmt::format("{:06}.label", index),
                            {reinterpret_cast<const char*>(taken.labels.data()), taken.labels.size() * 4});
    });
  }

  void radarSweep(std::uint32_t number, SimulationSummary& summary) {
    const double start = number * simulation_.radar()->model().sweep();
    RadarScan scan = simulation_.radarSweep(number, threads_);
    scan.label = "radar";
    for (Stamp& stamp : scan.stamps) stamp = stampAt(toSeconds(stamp));
    ++summary.radar_scans;
    write(navigation_.upTo(start), [this, taken = std::move(scan)] {
      if (simulation_.scenario().radar.png)
        writeFileAtomically(out_(".radar") / fmt::format("{}.png", std::llround(toSeconds(taken.stamps[0]) * 1e6)),
                            encodeOxfordRadar(taken));
      rawlog_.add(CObservationRadar(taken));
    });
  }

  void finish(double end) {
    write(navigation_.upTo(end), [] {});
    wait();
    rawlog_.finish();
  }

 private:
  void wait() {
    if (writing_.valid()) writing_.get();
  }
  /// Writes while the next sweep is traced, one after the other.
  template <class Last>
  void write(Observations first, Last last) {
    wait();
    writing_ = std::async(std::launch::async, [this, first = std::move(first), last = std::move(last)] {
      for (const auto& observation : first) rawlog_.add(*observation);
      last();
    });
  }

  Simulation& simulation_;
  const Outputs& out_;
  ThreadPool& threads_;
  RawlogWriter rawlog_;
  Navigation navigation_;
  std::future<void> writing_;  ///< last member: it ends before what it uses
};

/// All sweeps of both sensors by their start.
struct Sweep {
  double start;
  bool radar;
  std::uint32_t number;
};

std::vector<Sweep> schedule(const Simulation& simulation) {
  std::vector<Sweep> sweeps;
  for (const std::uint32_t k : simulation.recorded()) sweeps.push_back({simulation.sweepStart(k), false, k});
  for (std::uint32_t k = 0; k < simulation.radarScans(); ++k) {
    const double start = k * simulation.radar()->model().sweep();
    if (!simulation.scenario().faults.off(start)) sweeps.push_back({start, true, k});
  }
  std::stable_sort(sweeps.begin(), sweeps.end(), [](const Sweep& a, const Sweep& b) { return a.start < b.start; });
  return sweeps;
}

}  // namespace

SimulationSummary simulate(const Scenario& scenario, const SimulateOptions& options, const PluginContext& context) {
  const Outputs out(options.output);
  if (fs::exists(out.rawlog) && !options.overwrite)
    throw usageError("{} exists: choose another -o, or -w to replace it", out.rawlog.string());
  const auto begin = std::chrono::steady_clock::now();
  Simulation simulation(scenario, context);
  SimulationSummary summary;
  summary.triangles = simulation.world().mesh.size();
  summary.length_m = simulation.drive().length(), summary.duration_s = simulation.drive().duration();
  summary.collision = simulation.collision();
  if (!summary.collision.empty()) logWarn(context.log, "{}", summary.collision);
  const std::vector<Sweep> sweeps = schedule(simulation);
  if (sweeps.empty()) throw usageError("the drive lasts {:.2f} s: shorter than one sweep", summary.duration_s);

  if (out.rawlog.has_parent_path()) fs::create_directories(out.rawlog.parent_path());
  Recording recording(simulation, out, options.compression, context.threads);
  Progress progress("simulating", sweeps.size(), options.quiet);
  std::size_t done = 0;
  for (const Sweep& sweep : sweeps) {
    summary.stopped = options.stop != nullptr && *options.stop;
    if (summary.stopped) break;
    if (sweep.radar)
      recording.radarSweep(sweep.number, summary);
    else
      recording.lidarSweep(sweep.number, summary);
    progress.update(++done);
  }
  progress.finish();
  recording.finish(summary.stopped ? sweeps[done].start : summary.duration_s);
  summary.rays = simulation.lidar().rays();
  writeTruth(simulation, out, context.threads, summary);
  summary.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  summary.sha256 = sha256Of(out.rawlog);
  return summary;
}

}  // namespace scslam::sim
