#include "sim/outputs.h"

#include <algorithm>
#include <fstream>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/trajectory.h"
#include "sim/render.h"

namespace scslam::sim {

namespace {

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

/// The sensor whose scans stand for places: the LiDAR, or the radar where there is none.
struct Eye {
  Pose T_base_sensor;
  double sweep_s, max_range_m;
  std::vector<std::uint32_t> sweeps;  ///< numbers of those in the rawlog
};

Eye eyeOf(Simulation& simulation) {
  if (simulation.scenario().lidar.on || simulation.radar() == nullptr) {
    const SensorModel& sensor = simulation.lidar().sensor();
    return {sensor.T_base_sensor(), simulation.lidar().grid().sweep(), sensor.max_range_m, simulation.recorded()};
  }
  const RadarModel& radar = simulation.radar()->model();
  Eye eye{radar.T_base_sensor(), radar.sweep(), radar.maxRange(), {}};
  for (std::uint32_t k = 0; k < simulation.radarScans(); ++k) eye.sweeps.push_back(k);
  return eye;
}

void writePlaces(Simulation& simulation, const Outputs& out, ThreadPool& threads, SimulationSummary& summary) {
  const TruthParams& truth = simulation.scenario().truth;
  if (!truth.loops && !truth.aliases) return;
  const Eye eye = eyeOf(simulation);
  const auto places = placesOf(simulation.drive(), eye.T_base_sensor, eye.sweep_s, eye.sweeps, truth.place_every_m);
  if (truth.loops) {
    const auto found = revisits(places, simulation.scene(), eye.max_range_m, truth.min_travel_m, threads);
    summary.revisits = found.size();
    writeFileAtomically(out(".loops.csv"), revisitsCsv(places, found));
  }
  if (truth.aliases) {
    const auto found = aliases(places, simulation.scene(), eye.max_range_m, threads);
    summary.aliases = found.size();
    writeFileAtomically(out(".aliases.csv"), aliasesCsv(places, found));
  }
}

void writePictures(Simulation& simulation, const Outputs& out, ThreadPool& threads) {
  if (!simulation.scenario().truth.pictures) return;
  const RayScene& scene = simulation.scene();
  const std::uint32_t third = simulation.scans() / 3;
  writeFileAtomically(out(".world.png"),
                      renderTop(scene, simulation.world().mesh.bounds(), simulation.drive(), threads));
  if (simulation.scenario().lidar.on)
    writeFileAtomically(out(".scan.png"), renderScan(simulation.sweep(third, threads), simulation.lidar()));
  writeFileAtomically(out(".oblique.png"),
                      renderOblique(scene, simulation.drive(), simulation.sweepStart(third), threads));
}

}  // namespace

void writeTruth(Simulation& simulation, const Outputs& out, ThreadPool& threads, SimulationSummary& summary) {
  writeFileAtomically(out(".yaml"), dumpYaml(simulation.scenario()));
  writeTruthPoses(simulation, out);
  if (simulation.scenario().truth.firings) writeFirings(simulation, out);
  writePlaces(simulation, out, threads, summary);
  writePictures(simulation, out, threads);
}

}  // namespace scslam::sim
