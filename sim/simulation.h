// A scenario come to life: world, rays, drive, sensors; and the loop that writes the rawlog and the truth.
#pragma once
#include <mrpt/system/COutputLogger.h>

#include <atomic>
#include <filesystem>
#include <memory>

#include "scslam/core/parallel.h"
#include "sim/scenario.h"
#include "sim/truth.h"

namespace scslam::sim {

/// Everything a scenario states, built. Sweeps may be asked for in any order: each depends on its number alone.
class Simulation {
 public:
  Simulation(const Scenario& scenario, const PluginContext& context);

  const Scenario& scenario() const { return scenario_; }
  const World& world() const { return *world_; }
  const RayScene& scene() const { return *scene_; }
  const Trajectory& drive() const { return *drive_; }
  Lidar& lidar() { return *lidar_; }
  std::uint32_t scans() const;  ///< sweeps that begin and end within the drive
  double sweepStart(std::uint32_t number) const { return number * lidar_->grid().sweep(); }  ///< [s]

  /// Sweeps that reach the rawlog, in order: all but those the scenario loses.
  std::vector<std::uint32_t> recorded() const;
  /// The radar's sweep `number`, from number / rate on; only when the scenario has a radar.
  const Radar* radar() const { return radar_.get(); }
  std::uint32_t radarScans() const;  ///< sweeps that begin and end within the drive
  RadarScan radarSweep(std::uint32_t number, ThreadPool& threads);

  /// Sweep `number`, faults of the scenario applied.
  LidarScan sweep(std::uint32_t number, ThreadPool& threads);
  /// Where the robot touches something: "through brick at (x, y, z) after d m (t s)"; empty: nowhere.
  std::string collision() const;

 private:
  void poseActors(double t0, double t1);
  void applyFaults(LidarScan& scan, std::uint32_t number) const;
  Scenario scenario_;
  std::unique_ptr<World> world_;
  std::unique_ptr<RayScene> scene_;
  std::unique_ptr<Trajectory> drive_;
  std::unique_ptr<Lidar> lidar_;
  std::unique_ptr<Radar> radar_;
};

struct SimulateOptions {
  std::filesystem::path output;  ///< OUT.rawlog; the rest is named after it
  int compression = 1;
  bool overwrite = false, quiet = false;
  const std::atomic<bool>* stop = nullptr;
};

struct SimulationSummary {
  std::uint32_t scans = 0, radar_scans = 0;
  std::uint64_t rays = 0, points = 0;
  double duration_s = 0, length_m = 0, wall_s = 0;
  std::size_t triangles = 0, revisits = 0, aliases = 0;
  std::string sha256, collision;
  bool stopped = false;
};

/// Simulates the whole drive. @throw usageError when the output exists and overwrite is not set.
SimulationSummary simulate(const Scenario& scenario, const SimulateOptions& options, const PluginContext& context);

}  // namespace scslam::sim
