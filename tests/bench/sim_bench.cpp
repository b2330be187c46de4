// How fast the simulator traces: against a raw loop of Embree's 16-ray packets on the same mesh, in one run.
//   sim_bench [mesh.ply poses.txt]     (poses: x y z yaw per line; default: the shared city, else the town)
// CPU time of this process is what counts; medians of several turns.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <vector>

#include "scslam/core/log.h"
#include "sim/mesh_file.h"
#include "sim/simulation.h"

using namespace scslam;
using namespace scslam::sim;

namespace {

double cpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + std::ssize(values) / 2, values.end());
  return values[values.size() / 2];
}

/// 64 rings over +-16.611 deg, 1024 columns counter-clockwise from the heading, 120 m.
SensorModel plain64() {
  SensorModel sensor;
  sensor.name = "64 x 1024", sensor.rings = 64, sensor.columns = 1024, sensor.clockwise = false;
  sensor.min_range_m = 0, sensor.max_range_m = 120;
  for (int r = 0; r < 64; ++r) sensor.elevation_deg.push_back(-16.611 + 2 * 16.611 * r / 63);
  return sensor;
}

std::vector<Pose> readPoses(const std::string& file) {
  std::ifstream in(file);
  std::vector<Pose> poses;
  for (double x, y, z, yaw; in >> x >> y >> z >> yaw;) poses.push_back(poseFromYaw(yaw, {x, y, z}));
  return poses;
}

struct Total {
  std::uint64_t hits = 0;
  double range = 0;
};

/// The same rays, tile by tile, with nothing around rtcIntersect16 but filling the packet.
Total rawLoop(const RayScene& scene, const BeamGrid& grid, const Pose& T) {
  Total total;
  const Eigen::Matrix3f R = T.linear().cast<float>();
  const Eigen::Vector3f t = T.translation().cast<float>();
  RayPacket rays;
  for (std::size_t tile = 0; tile < grid.tiles(); ++tile) {
    const float* d = grid.directions(tile);
    for (int i = 0; i < 16; ++i) {
      rays.ray.org_x[i] = t.x(), rays.ray.org_y[i] = t.y(), rays.ray.org_z[i] = t.z();
      rays.ray.dir_x[i] = R(0, 0) * d[i] + R(0, 1) * d[16 + i] + R(0, 2) * d[32 + i];
      rays.ray.dir_y[i] = R(1, 0) * d[i] + R(1, 1) * d[16 + i] + R(1, 2) * d[32 + i];
      rays.ray.dir_z[i] = R(2, 0) * d[i] + R(2, 1) * d[16 + i] + R(2, 2) * d[32 + i];
      rays.ray.tnear[i] = 0, rays.ray.tfar[i] = 120, rays.ray.time[i] = 0, rays.ray.mask[i] = 0xFFFFFFFF;
      rays.ray.flags[i] = 0, rays.ray.id[i] = 0, rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    }
    scene.trace(rays);
    for (int i = 0; i < 16; ++i)
      if (rays.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID)
        ++total.hits, total.range += static_cast<double>(rays.ray.tfar[i]);
  }
  return total;
}

void benchMesh(const std::string& mesh_file, const std::string& poses_file, const PluginContext& context) {
  World world;
  world.name = mesh_file, world.mesh = readMesh(mesh_file, {}, context.log);
  const RayScene scene(world);
  const std::vector<Pose> poses = readPoses(poses_file);
  Lidar lidar(plain64(), {}, {}, 1);
  const double rays = static_cast<double>(poses.size()) * 64 * 1024;
  std::vector<double> raw, ranges, full;
  Total total;
  std::vector<float> out;
  std::vector<Pose> control;
  for (int k = 0; k < 40; ++k) control.push_back(poseFromYaw(0.05 * k, {2.0 * k, 0, 1.8}));
  for (int turn = 0; turn < 5; ++turn) {
    double begin = cpuSeconds();
    for (const Pose& T : poses) rawLoop(scene, lidar.grid(), T);
    raw.push_back(cpuSeconds() - begin);
    begin = cpuSeconds();
    total = {};
    for (const Pose& T : poses) {
      lidar.ranges(scene, T, context.threads, out);
      for (const float r : out)
        if (std::isfinite(r)) ++total.hits, total.range += static_cast<double>(r);
    }
    ranges.push_back(cpuSeconds() - begin);
    begin = cpuSeconds();
    for (std::size_t k = 0; k < poses.size(); ++k) {
      // The full model rolls: each sweep from its own short drive through the pose, 20 m/s and 30 deg/s.
      std::vector<Pose> near;
      for (int n = -1; n < 4; ++n) near.push_back(poses[k] * poseFromYaw(0.0524 * n, {2.0 * n, 0, 0}));
      lidar.scan(scene, Trajectory(near, 0.1), 0, static_cast<std::uint32_t>(k), context.threads);
    }
    full.push_back(cpuSeconds() - begin);
  }
  const auto rate = [&](const std::vector<double>& seconds) { return rays / median(seconds) / 1e6; };
  fmt::print("{}: {} triangles, {} poses, {} hits, mean range {:.6f} m\n", mesh_file, world.mesh.size(), poses.size(),
             total.hits, total.range / static_cast<double>(total.hits));
  fmt::print("{:<34}{:8.2f} Mrays/CPU-s\n", "raw rtcIntersect16", rate(raw));
  fmt::print("{:<34}{:8.2f} Mrays/CPU-s  {:4.0f} % of raw\n", "ranges", rate(ranges),
             100 * median(raw) / median(ranges));
  fmt::print("{:<34}{:8.2f} Mrays/CPU-s  {:4.0f} % of raw\n", "full model (rolling, noise, echo)", rate(full),
             100 * median(raw) / median(full));
}

void benchTown(const PluginContext& context) {
  Scenario scenario;
  scenario.drive.lane_m = -1.5, scenario.drive.duration_s = 10;
  Simulation simulation(scenario, context);
  std::vector<double> seconds;
  for (std::uint32_t second = 0; second < 8; ++second) {
    const double begin = cpuSeconds();
    for (std::uint32_t k = 0; k < 10; ++k) simulation.sweep(10 * second + k, context.threads);
    seconds.push_back(cpuSeconds() - begin);
  }
  fmt::print("town, {} triangles, {} actors: {:.3f} CPU-s for a simulated second of {}\n",
             simulation.world().mesh.size(), simulation.world().actors.size(), median(seconds), scenario.lidar.sensor);
}

}  // namespace

int main(int argc, char** argv) {
  Log log(mrpt::system::LVL_WARN);
  ThreadPool threads(1);
  const std::string shared = std::string(SCSLAM_SOURCE_DIR) + "/../shared/tools/city_100k";
  const std::string mesh = argc > 2 ? argv[1] : shared + ".ply", poses = argc > 2 ? argv[2] : shared + ".poses.txt";
  if (std::filesystem::exists(mesh))
    benchMesh(mesh, poses, {threads, log});
  else
    fmt::print("no {}: only the town is measured\n", mesh);
  benchTown({threads, log});
}
