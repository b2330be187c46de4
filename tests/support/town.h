// A small made-up town and drives through it, for tests that need more than a room.
#pragma once
#include <filesystem>
#include <vector>

#include "scslam/core/cloud.h"
#include "scslam/core/trajectory.h"

namespace scslam::test {

/// Surfaces of buildings, cars and poles around streets on a plane; frame: world, z up, ground at 0.
class Town {
 public:
  explicit Town(std::uint32_t seed = 1);
  /// What a sensor at T_world_sensor sees up to `range_m` (no occlusion), about `points` points, other ones for each
  /// scan_seed, with 1 cm of noise; frame sensor.
  Cloud scan(const Pose& T_world_sensor, std::uint32_t scan_seed, std::size_t points = 4000, double range_m = 35) const;

 private:
  Cloud world_;
};

/// A drive once around a block of 44 x 28 m and on for another third of it, `step_m` between scans, sensor 1.7 m above
/// ground.
std::vector<Pose> aroundTheBlock(double step_m = 1.5, double laps = 1.3);
/// Out along a street of `length_m`, a turn on the spot, and back 1 m beside it.
std::vector<Pose> outAndBack(double length_m = 40, double step_m = 1.5);

/// `truth` with drift: each step turned by yaw_deg_per_m and stretched by `scale`.
std::vector<Pose> withDrift(const std::vector<Pose>& truth, double yaw_deg_per_m = 0.15, double scale = 1.01);

/// KITTI odometry layout in `folder`: velodyne/NNNNNN.bin, times.txt (10 Hz), poses.txt (truth), odometry.txt
/// (drifting).
void writeKittiDrive(const std::filesystem::path& folder, const Town& town, const std::vector<Pose>& truth,
                     const std::vector<Pose>& odometry, std::size_t points = 4000);

/// Name, size and checksum of every file below `folder`, sorted, but for those in `except`.
std::vector<std::string> contents(const std::filesystem::path& folder,
                                  const std::vector<std::string>& except = {"metrics.json"});

}  // namespace scslam::test
