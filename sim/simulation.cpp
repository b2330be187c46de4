#include "sim/simulation.h"

#include <algorithm>
#include <cmath>

#include "scslam/core/error.h"
#include "scslam/sensor/sensor_tables.h"

namespace scslam::sim {

using Eigen::Vector3d;

namespace {

/// The ground below a point, seen from a metre above it and through whatever moves about there.
GroundHeight groundOf(const RayScene& scene) {
  return [&scene](double x, double y, double z_hint) {
    constexpr int kSurfaces = 16;  // of actors, at most
    constexpr double kReach = 6, kSkin = 1e-4;
    double eye = z_hint + 1;
    for (int k = 0; k < kSurfaces; ++k) {
      const auto hit = scene.first({x, y, eye}, -Vector3d::UnitZ(), kReach - (z_hint + 1 - eye));
      if (!hit) return std::nan("");
      eye -= hit->range;
      if (!hit->surface.actor) return eye;
      eye -= kSkin;
    }
    return std::nan("");
  };
}

SensorModel mounted(const LidarParams& params) {
  SensorModel sensor = loadSensorModel(params.sensor);
  if (params.translation_m.size() != 3 || params.rpy_deg.size() != 3)
    throw usageError("lidar.translation_m and lidar.rpy_deg need three numbers each");
  sensor.translation_m = params.translation_m, sensor.rpy_deg = params.rpy_deg;
  return sensor;
}

void checkPairs(const std::vector<double>& list, const char* key) {
  if (list.size() % 2 != 0) throw usageError("{} needs pairs of numbers: from, to, ...", key);
}

/// `share` of the rings, drawn by lot.
std::vector<bool> deadRings(int rings, double share, const CounterRandom& random) {
  std::vector<std::pair<float, std::size_t>> lots;
  for (int r = 0; r < rings; ++r)
    lots.emplace_back(uniformOf(random.block(0, 0, static_cast<std::uint32_t>(r), 1)[0]), static_cast<std::size_t>(r));
  std::sort(lots.begin(), lots.end());
  std::vector<bool> dead(lots.size(), false);
  for (std::size_t k = 0; k < static_cast<std::size_t>(std::lround(share * rings)); ++k) dead[lots[k].second] = true;
  return dead;
}

}  // namespace

Simulation::Simulation(const Scenario& scenario, const PluginContext& context) : scenario_(scenario) {
  checkPairs(scenario.faults.dirty_deg, "faults.dirty_deg");
  checkPairs(scenario.faults.off_s, "faults.off_s");
  world_ = std::make_unique<World>(scenario.world.kind.create(context)->generate(scenario.worldSeed()));
  scene_ = std::make_unique<RayScene>(*world_);
  drive_ = std::make_unique<Trajectory>(planDrive(scenario.drive, world_->routes, groundOf(*scene_)));
  lidar_ = std::make_unique<Lidar>(mounted(scenario.lidar), scenario.lidar.effects, scenario.weather,
                                   static_cast<std::uint64_t>(scenario.seed));
  if (scenario.radar.on)
    radar_ = std::make_unique<Radar>(scenario.radar.model(), static_cast<std::uint64_t>(scenario.seed));
}

std::uint32_t Simulation::scans() const {
  const double sweep = lidar_->grid().sweep();
  return static_cast<std::uint32_t>(std::floor(drive_->duration() / sweep + 1e-9));
}

void Simulation::poseActors(double t0, double t1) {
  scene_->poseActors(t0, t1, drive_->pose((t0 + t1) / 2).translation());
}

std::vector<std::uint32_t> Simulation::recorded() const {
  const CounterRandom random(static_cast<std::uint64_t>(scenario_.seed), RandomStream::kFaults);
  std::vector<std::uint32_t> numbers;
  for (std::uint32_t k = 0; k < scans() && scenario_.lidar.on; ++k)
    if (static_cast<double>(uniformOf(random.block(k)[0])) >= scenario_.faults.lost_scans &&
        !scenario_.faults.off(sweepStart(k)))
      numbers.push_back(k);
  return numbers;
}

LidarScan Simulation::sweep(std::uint32_t number, ThreadPool& threads) {
  const double start = sweepStart(number);
  poseActors(start, start + lidar_->grid().sweep());
  LidarScan scan = lidar_->scan(*scene_, *drive_, start, number, threads);
  applyFaults(scan, number);
  return scan;
}

std::uint32_t Simulation::radarScans() const {
  return radar_ ? static_cast<std::uint32_t>((drive_->duration() + 1e-9) / radar_->model().sweep()) : 0;
}

RadarScan Simulation::radarSweep(std::uint32_t number, ThreadPool& threads) {
  const double start = number * radar_->model().sweep();
  poseActors(start, start + radar_->model().sweep());
  return radar_->scan(*scene_, *drive_, start, number, threads, world_.get());
}

void Simulation::applyFaults(LidarScan& scan, std::uint32_t number) const {
  const FaultParams& faults = scenario_.faults;
  if (faults.lost_rings <= 0 && faults.dirty_deg.empty()) return;
  const CounterRandom random(static_cast<std::uint64_t>(scenario_.seed), RandomStream::kFaults, 1);
  const std::vector<bool> dead = deadRings(lidar_->grid().rings(), faults.lost_rings, random);
  std::vector<std::uint8_t> keep(scan.cloud.size(), 1);
  for (std::size_t i = 0; i < keep.size(); ++i) {
    const std::uint32_t ring = scan.cloud.ring[i];
    if (dead[ring]) keep[i] = 0;
    const double azimuth = std::atan2(scan.cloud.y[i], scan.cloud.x[i]) * 180 / M_PI;
    for (std::size_t k = 0; k + 1 < faults.dirty_deg.size(); k += 2) {
      const double into = azimuth - faults.dirty_deg[k] - 360 * std::floor((azimuth - faults.dirty_deg[k]) / 360);
      const auto u = uniformOf(random.block(number, static_cast<std::uint32_t>(i), ring, 2)[0]);
      if (into < faults.dirty_deg[k + 1] - faults.dirty_deg[k] && static_cast<double>(u) < faults.dirty_loss)
        keep[i] = 0;
    }
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < keep.size(); ++i)
    if (keep[i] != 0) scan.labels[kept++] = scan.labels[i];
  scan.labels.resize(kept);
  scan.cloud.filter(keep);
}

std::string Simulation::collision() const {
  constexpr double kStep = 0.25;  // [s]
  double travel = 0;
  for (double t = kStep; t <= drive_->duration(); t += kStep) {
    const Pose from = drive_->pose(t - kStep), to = drive_->pose(t);
    const Vector3d way = to.translation() - from.translation();
    travel += way.norm();
    if (way.norm() < 0.02) continue;
    // Low ahead of the wheels, which climb on what they reach; and higher up.
    for (const Vector3d& body : {Vector3d(1.6, -0.8, 0.4), Vector3d(1.6, 0, 0.4), Vector3d(1.6, 0.8, 0.4),
                                 Vector3d(0, -0.8, 1.0), Vector3d(0, 0, 1.0), Vector3d(0, 0.8, 1.0)}) {
      const auto hit =
          scene_->first(from * body, (to * body - from * body).normalized(), (to * body - from * body).norm());
      if (!hit || hit->surface.label >= 250) continue;
      const Vector3d at = to.translation();
      return fmt::format(
          "the robot drives through {} at ({:.1f}, {:.1f}, {:.1f}), {:.1f} m and {:.1f} s into the drive",
          hit->surface.material->name, at.x(), at.y(), at.z(), travel, t);
    }
  }
  return "";
}

}  // namespace scslam::sim
