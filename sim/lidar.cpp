#include "sim/lidar.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "scslam/core/simd.h"

namespace scslam::sim {

namespace {

constexpr std::size_t kColumnsPerChunk = 32;  ///< a multiple of every tile's columns

void reset(RayPacket& rays, float max_range) {
  for (int i = 0; i < 16; ++i) {
    rays.ray.tnear[i] = 0, rays.ray.tfar[i] = max_range, rays.ray.time[i] = 0;
    rays.ray.mask[i] = 0xFFFFFFFF, rays.ray.flags[i] = 0, rays.ray.id[i] = 0;
    rays.hit.geomID[i] = rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
}

std::array<float, 3> asFloats(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace

void LidarEffects::describe(ParamVisitor& v) {
  v.field("rolling", rolling, "the robot moves while the sensor sweeps");
  v.field("noise", noise, "range noise and quantum");
  v.field("dropout", dropout, "weak echoes are lost");
  v.field("beam_width", beam_width, "beams are split by edges: mixed pixels");
  v.field("returns", returns, "which echo of a split beam is reported", {"strongest", "last", "dual"});
}

Lidar::Lidar(SensorModel sensor, LidarEffects effects, Weather weather, std::uint64_t seed, std::uint32_t unit)
    : sensor_(std::move(sensor)),
      effects_(std::move(effects)),
      weather_(std::move(weather)),
      random_(seed, RandomStream::kLidar, unit),
      grid_(sensor_),
      T_base_sensor_(sensor_.T_base_sensor()),
      columns_(static_cast<std::size_t>(grid_.columns())) {}

void Lidar::poseColumns(const Trajectory& drive, double start_s, ThreadPool& threads) {
  threads.forEachChunk(columns_.size(), kColumnsPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t c = begin; c < end; ++c) {
      const double t = start_s + (effects_.rolling ? grid_.columnTime(static_cast<int>(c)) : 0);
      const Pose T_world_base = drive.pose(t), T_world_sensor = T_world_base * T_base_sensor_;
      ColumnPose& column = columns_[c];
      for (int k = 0; k < 9; ++k)
        column.R[static_cast<std::size_t>(k)] = static_cast<float>(T_world_sensor.linear()(k / 3, k % 3));
      column.t = asFloats(T_world_sensor.translation());
      if (!grid_.beamsHaveTimes()) continue;
      const MotionState s = drive.state(t);
      const Eigen::Vector3d arm = T_world_base.linear() * T_base_sensor_.translation();
      const Eigen::Vector3d spin_world = T_world_base.linear() * s.angular_velocity;
      column.velocity = asFloats(s.velocity + spin_world.cross(arm));
      column.spin = asFloats(spin_world);
    }
  });
}

Lidar::LanePoses Lidar::lanePoses(std::size_t tile) const {
  LanePoses poses;
  for (int lane = 0; lane < 16; ++lane) {
    const auto c = static_cast<std::size_t>(std::min(grid_.columnOf(tile, lane), grid_.columns() - 1));
    for (int k = 0; k < 9; ++k) poses.m[k][lane] = columns_[c].R[static_cast<std::size_t>(k)];
    for (int k = 0; k < 3; ++k) poses.m[9 + k][lane] = columns_[c].t[static_cast<std::size_t>(k)];
  }
  return poses;
}

/// Directions (and origins, when there are any) of a tile, turned into the world.
SCSLAM_KERNEL
void Lidar::turn(const LanePoses& poses, const float* d, const float* o, RTCRay16& ray) {
  const auto& m = poses.m;
  for (int i = 0; i < 16; ++i) {
    ray.dir_x[i] = m[0][i] * d[i] + m[1][i] * d[16 + i] + m[2][i] * d[32 + i];
    ray.dir_y[i] = m[3][i] * d[i] + m[4][i] * d[16 + i] + m[5][i] * d[32 + i];
    ray.dir_z[i] = m[6][i] * d[i] + m[7][i] * d[16 + i] + m[8][i] * d[32 + i];
    ray.org_x[i] = m[9][i], ray.org_y[i] = m[10][i], ray.org_z[i] = m[11][i];
  }
  if (o == nullptr) return;
  for (int i = 0; i < 16; ++i) {
    ray.org_x[i] += m[0][i] * o[i] + m[1][i] * o[16 + i] + m[2][i] * o[32 + i];
    ray.org_y[i] += m[3][i] * o[i] + m[4][i] * o[16 + i] + m[5][i] * o[32 + i];
    ray.org_z[i] += m[6][i] * o[i] + m[7][i] * o[16 + i] + m[8][i] * o[32 + i];
  }
}

/// Beams that fire after their column began: the robot went on meanwhile (first order: at most 48 us).
void Lidar::aim(RayPacket& rays, std::size_t tile) const {
  std::copy_n(grid_.times(tile), 16, rays.ray.time);
  if (!grid_.beamsHaveTimes() || !effects_.rolling) return;
  for (int i = 0; i < 16; ++i) {
    const int ring = std::min(grid_.ringOf(tile, i), grid_.rings() - 1);
    const int column = std::min(grid_.columnOf(tile, i), grid_.columns() - 1);
    const ColumnPose& pose = columns_[static_cast<std::size_t>(column)];
    const auto dt = static_cast<float>(grid_.beamTime(ring));
    rays.ray.org_x[i] += dt * pose.velocity[0];
    rays.ray.org_y[i] += dt * pose.velocity[1];
    rays.ray.org_z[i] += dt * pose.velocity[2];
    const float x = rays.ray.dir_x[i], y = rays.ray.dir_y[i], z = rays.ray.dir_z[i];
    rays.ray.dir_x[i] += dt * (pose.spin[1] * z - pose.spin[2] * y);
    rays.ray.dir_y[i] += dt * (pose.spin[2] * x - pose.spin[0] * z);
    rays.ray.dir_z[i] += dt * (pose.spin[0] * y - pose.spin[1] * x);
  }
}

Lidar::Echo Lidar::echoOf(const RayScene& scene, const RayPacket& rays, int lane, float cosine) const {
  if (rays.hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID) return {};
  const float r = rays.ray.tfar[lane];
  const Surface surface = scene.surface(rays, lane);
  const SignalModel& s = sensor_.signal;
  const Material& m = *surface.material;
  const float lobe = std::clamp((cosine - 0.5F) / 0.5F, 0.0F, 1.0F);
  float strength =
      m.reflectance * (1 - m.specular) * m.backscatter(cosine) + m.retro * static_cast<float>(s.retro_gain) * lobe;
  const auto near = static_cast<float>(s.near_m);
  if (r < near) strength *= std::pow(r / near, static_cast<float>(s.near_power));
  if (!weather_.clear()) strength *= static_cast<float>(std::exp(-2 * weather_.extinction() * static_cast<double>(r)));
  return {r, strength * static_cast<float>(s.gain) / (r * r), surface.label, surface.instance};
}

void Lidar::traceTile(const RayScene& scene, std::size_t tile, const LanePoses& poses) {
  RayPacket rays;
  turn(poses, grid_.directions(tile), grid_.origins(tile), rays.ray);
  reset(rays, static_cast<float>(sensor_.max_range_m));
  aim(rays, tile);
  const std::uint32_t active = grid_.active(tile);
  if (active != 0) scene.trace(rays, active);
  float cosine[16];
  scene.incidence(rays, cosine);
  const int first_ring = grid_.ringOf(tile, 0), first_column = grid_.columnOf(tile, 0);
  for (int i = 0; i < 16; ++i) {
    const int ring = first_ring + grid_.ringOf(0, i), column = first_column + grid_.columnOf(0, i);
    if (ring >= grid_.rings() || column >= grid_.columns()) continue;
    echoes_[static_cast<std::size_t>(column * grid_.rings() + ring)] =
        (active >> i & 1U) != 0 ? echoOf(scene, rays, i, cosine[i]) : Echo{};
  }
}

LidarScan Lidar::scan(const RayScene& scene, const Trajectory& drive, double start_s, std::uint32_t number,
                      ThreadPool& threads) {
  poseColumns(drive, start_s, threads);
  echoes_.resize(static_cast<std::size_t>(grid_.rings() * grid_.columns()));
  second_.assign(echoes_.size(), {});
  const std::size_t tiles_per_chunk =
      grid_.tilesAcross() * (kColumnsPerChunk / static_cast<std::size_t>(grid_.tileColumns()));
  threads.forEachChunk(grid_.tiles(), tiles_per_chunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    LanePoses poses;
    for (std::size_t tile = begin; tile < end; ++tile) {
      if (tile % grid_.tilesAcross() == 0) poses = lanePoses(tile);
      traceTile(scene, tile, poses);
    }
  });
  for (std::size_t tile = 0; tile < grid_.tiles(); ++tile)
    rays_ += static_cast<std::uint64_t>(std::popcount(grid_.active(tile)));
  const auto columns = static_cast<std::size_t>(grid_.columns());
  std::vector<LidarScan> parts(chunkCount(columns, kColumnsPerChunk));
  if (effects_.beam_width && sensor_.beams.divergence_mrad > 0) {
    const std::vector<Echo> centres = echoes_;
    std::vector<std::uint64_t> more(parts.size());
    threads.forEachChunk(columns, kColumnsPerChunk, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
      more[chunk] = splitBeams(scene, centres, static_cast<int>(begin), static_cast<int>(end));
    });
    rays_ = std::accumulate(more.begin(), more.end(), rays_);
  }
  threads.forEachChunk(columns, kColumnsPerChunk, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
    collect(static_cast<int>(begin), static_cast<int>(end), number, parts[chunk]);
  });
  return joined(parts);
}

LidarScan Lidar::joined(const std::vector<LidarScan>& parts) {
  LidarScan scan;
  for (const LidarScan& part : parts) {
    const auto add = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    add(scan.cloud.x, part.cloud.x), add(scan.cloud.y, part.cloud.y), add(scan.cloud.z, part.cloud.z);
    add(scan.cloud.intensity, part.cloud.intensity), add(scan.cloud.dt, part.cloud.dt);
    add(scan.cloud.ring, part.cloud.ring), add(scan.labels, part.labels);
  }
  return scan;
}

void Lidar::ranges(const RayScene& scene, const Pose& T_world_sensor, ThreadPool& threads,
                   std::vector<float>& out) const {
  out.resize(grid_.tiles() * 16);
  LanePoses poses;
  for (int lane = 0; lane < 16; ++lane) {
    for (int k = 0; k < 9; ++k) poses.m[k][lane] = static_cast<float>(T_world_sensor.linear()(k / 3, k % 3));
    for (int k = 0; k < 3; ++k) poses.m[9 + k][lane] = static_cast<float>(T_world_sensor.translation()[k]);
  }
  threads.forEachChunk(grid_.tiles(), 256, [&](std::size_t begin, std::size_t end, std::size_t) {
    RayPacket rays;
    for (std::size_t tile = begin; tile < end; ++tile) {
      turn(poses, grid_.directions(tile), grid_.origins(tile), rays.ray);
      reset(rays, static_cast<float>(sensor_.max_range_m));
      scene.trace(rays, grid_.active(tile));
      for (int i = 0; i < 16; ++i)
        out[tile * 16 + static_cast<std::size_t>(i)] =
            rays.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID ? std::numeric_limits<float>::infinity() : rays.ray.tfar[i];
    }
  });
}

}  // namespace scslam::sim
