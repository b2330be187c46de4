#include "support/town.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>

#include "scslam/core/bytes.h"
#include "scslam/core/file.h"

namespace scslam::test {
namespace {

double unit(std::mt19937& random) { return static_cast<double>(random()) / 4294967296.0; }

void addBox(Cloud& world, std::mt19937& random, const Eigen::Vector3d& lo, const Eigen::Vector3d& size) {
  const double side = 2 * (size.x() + size.y()) * size.z(), top = size.x() * size.y();
  const auto n = static_cast<int>((side + top) * 40);
  for (int i = 0; i < n; ++i) {
    const double a = unit(random), b = unit(random), pick = unit(random) * (side + top);
    Eigen::Vector3d p = lo;
    if (pick < top) {
      p += Eigen::Vector3d(a * size.x(), b * size.y(), size.z());
    } else {
      const double along = a * 2 * (size.x() + size.y());
      p.z() += b * size.z();
      if (along < size.x())
        p.x() += along;
      else if (along < size.x() + size.y())
        p += Eigen::Vector3d(size.x(), along - size.x(), 0);
      else if (along < 2 * size.x() + size.y())
        p += Eigen::Vector3d(along - size.x() - size.y(), size.y(), 0);
      else
        p.y() += along - 2 * size.x() - size.y();
    }
    world.push(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
  }
}

std::uint32_t mixed(std::uint32_t a, std::uint32_t b) {
  std::uint32_t h = a * 0x9E3779B1u ^ (b + 0x7F4A7C15u) * 0x85EBCA77u;
  h = (h ^ (h >> 15)) * 0x2C1B3C6Du;
  return h ^ (h >> 13);
}

}  // namespace

Town::Town(std::uint32_t seed) {
  std::mt19937 random(seed);
  for (int i = 0; i < 400000; ++i)
    world_.push(static_cast<float>(-60 + 160 * unit(random)), static_cast<float>(-60 + 140 * unit(random)), 0.0f);
  // Buildings inside and outside the block's street (a ring road around x 0..44, y 0..28), of different sizes and gaps.
  for (int i = 0; i < 70; ++i) {
    const Eigen::Vector3d size(2 + 9 * unit(random), 2 + 7 * unit(random), 2 + 10 * unit(random));
    const Eigen::Vector3d lo(-35 + 110 * unit(random), -35 + 95 * unit(random), 0);
    const auto blocks = [&](double x0, double y0, double x1, double y1) {
      return lo.x() < x1 && lo.x() + size.x() > x0 && lo.y() < y1 && lo.y() + size.y() > y0;
    };
    const double w = 3.5;
    if (blocks(-w, -w, 44 + w, w) || blocks(-w, 28 - w, 44 + w, 28 + w) || blocks(-w, -w, w, 28 + w) ||
        blocks(44 - w, -w, 44 + w, 28 + w))
      continue;
    addBox(world_, random, lo, size);
  }
  for (int i = 0; i < 40; ++i) {  // cars and poles at the kerb
    const double along = unit(random) * 44, side = i % 2 == 0 ? -3.2 : 3.0;
    const bool pole = i % 3 == 0;
    const Eigen::Vector3d size = pole ? Eigen::Vector3d(0.2, 0.2, 5) : Eigen::Vector3d(4, 1.7, 1.5);
    addBox(world_, random, {along, (i % 4 < 2 ? 0.0 : 28.0) + side, 0}, size);
  }
}

Cloud Town::scan(const Pose& T_world_sensor, std::uint32_t scan_seed, std::size_t points, double range_m) const {
  const Eigen::Vector3f origin = T_world_sensor.translation().cast<float>();
  const auto range2 = static_cast<float>(range_m * range_m);
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < world_.size(); ++i)
    if ((world_.point(i) - origin).squaredNorm() < range2) near.push_back(i);
  const std::uint32_t keep_below =
      near.size() <= points
          ? 0xFFFFFFFFu
          : static_cast<std::uint32_t>(4294967295.0 * static_cast<double>(points) / static_cast<double>(near.size()));
  std::mt19937 random(scan_seed);
  Cloud seen;
  for (const std::size_t i : near) {
    if (mixed(static_cast<std::uint32_t>(i), scan_seed) > keep_below) continue;
    const auto noise = [&random] {
      return static_cast<float>(0.01 * (unit(random) + unit(random) + unit(random) - 1.5) * 2);
    };
    seen.push(world_.x[i] + noise(), world_.y[i] + noise(), world_.z[i] + noise());
  }
  transformInPlace(seen, T_world_sensor.inverse());
  return seen;
}

std::vector<Pose> aroundTheBlock(double step_m, double laps) {
  constexpr double kWidth = 44, kDepth = 28, kRound = 5;  // corners are quarter circles
  const double straight_x = kWidth - 2 * kRound, straight_y = kDepth - 2 * kRound, corner = kRound * M_PI / 2;
  const double lap = 2 * (straight_x + straight_y) + 4 * corner;
  std::vector<Pose> poses;
  for (double s = 0; s < laps * lap; s += step_m) {
    double rest = std::fmod(s, lap), heading = 0;
    Eigen::Vector3d p(kRound, 0, 1.7);
    for (int leg = 0;; ++leg) {
      const double straight = leg % 2 == 0 ? straight_x : straight_y;
      const Eigen::Vector3d forward(std::cos(heading), std::sin(heading), 0), left(-forward.y(), forward.x(), 0);
      if (rest < straight) {
        p += rest * forward;
        break;
      }
      p += straight * forward;
      rest -= straight;
      const double turn = std::min(rest, corner) / kRound;
      p += kRound * (std::sin(turn) * forward + (1 - std::cos(turn)) * left);
      heading += turn;
      if (rest < corner) break;
      rest -= corner;
    }
    poses.push_back(poseFromYaw(heading, p));
  }
  return poses;
}

std::vector<Pose> outAndBack(double length_m, double step_m) {
  std::vector<Pose> poses;
  for (double x = 0; x <= length_m; x += step_m) poses.push_back(poseFromYaw(0, {x, 0, 1.7}));
  for (double yaw = 0.3; yaw < M_PI; yaw += 0.3) poses.push_back(poseFromYaw(yaw, {length_m, yaw / M_PI, 1.7}));
  for (double x = length_m; x >= 0; x -= step_m) poses.push_back(poseFromYaw(M_PI, {x, 1, 1.7}));
  return poses;
}

std::vector<Pose> withDrift(const std::vector<Pose>& truth, double yaw_deg_per_m, double scale) {
  std::vector<Pose> drifting = {truth.front()};
  for (std::size_t i = 1; i < truth.size(); ++i) {
    Pose step = truth[i - 1].inverse() * truth[i];
    const double metres = step.translation().norm();
    step.translation() *= scale;
    drifting.push_back(drifting.back() * step * poseFromYaw(yaw_deg_per_m * metres * M_PI / 180, {0, 0, 0}));
  }
  return drifting;
}

void writeKittiDrive(const std::filesystem::path& folder, const Town& town, const std::vector<Pose>& truth,
                     const std::vector<Pose>& odometry, std::size_t points) {
  std::filesystem::create_directories(folder / "velodyne");
  std::string times;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Cloud cloud = town.scan(truth[i], static_cast<std::uint32_t>(i), points);
    std::vector<float> values;
    for (std::size_t k = 0; k < cloud.size(); ++k)
      values.insert(values.end(), {cloud.x[k], cloud.y[k], cloud.z[k], 0.5f});
    std::ofstream file(folder / "velodyne" / fmt::format("{:06d}.bin", i), std::ios::binary);
    file.write(reinterpret_cast<const char*>(values.data()),
               static_cast<std::streamsize>(values.size() * sizeof(float)));
    times += fmt::format("{:.6f}\n", 0.1 * static_cast<double>(i));
  }
  writeFileAtomically(folder / "times.txt", times);
  writeFileAtomically(folder / "poses.txt", formatKitti(truth));
  writeFileAtomically(folder / "odometry.txt", formatKitti(odometry));
}

std::vector<std::string> contents(const std::filesystem::path& folder, const std::vector<std::string>& except) {
  std::vector<std::string> result;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    const std::string name = std::filesystem::relative(entry.path(), folder).string();
    if (std::find(except.begin(), except.end(), name) != except.end()) continue;
    const std::string bytes = readFile(entry.path());
    result.push_back(fmt::format("{}: {} bytes, CRC {:08x}", name, bytes.size(), crc32Of(bytes)));
  }
  std::sort(result.begin(), result.end());
  return result;
}

}  // namespace scslam::test
