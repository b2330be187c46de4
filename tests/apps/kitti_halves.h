// One real street as two sessions: its even and its odd scans, mapped apart, the odd ones in a frame of their own.
#pragma once
#include "apps/town_sessions.h"
#include "scslam/core/bytes.h"
#include "scslam/core/file.h"
#include "scslam/core/pcd.h"

namespace scslam::test {

struct KittiHalves {
  TownSession even, odd;
};

inline Cloud kittiScan(const std::filesystem::path& recording, std::size_t k) {
  return readPcd(recording / "scans" / fmt::format("{:06d}.pcd", k));
}

/// KITTI layout of every second scan from `first` on, mapped with the recorded (drifting) odometry.
inline TownSession kittiHalf(const std::filesystem::path& recording, std::size_t first, const Pose& T_odom_recorded,
                             const std::filesystem::path& folder) {
  const Trajectory truth = readTrajectory(recording / "poses_gt.txt");
  const Trajectory odometry = readTrajectory(recording / "poses_laser_odom.txt");
  TownSession half{folder.string() + ".session", folder, folder / "poses.txt", {}};
  std::vector<Pose> T_odom_base;
  std::string times;
  std::filesystem::create_directories(folder / "velodyne");
  for (std::size_t k = first; k < truth.poses.size(); k += 2) {
    const Cloud cloud = kittiScan(recording, k);
    ByteWriter bytes;
    for (std::size_t i = 0; i < cloud.size(); ++i)
      for (const float value : {cloud.x[i], cloud.y[i], cloud.z[i], 0.f}) bytes.put(value);
    writeFileAtomically(folder / "velodyne" / fmt::format("{:06d}.bin", T_odom_base.size()), bytes.bytes());
    times += fmt::format("{:.3f}\n", 0.25 * static_cast<double>(k));
    half.T_world_base.push_back(truth.poses[k].T);
    T_odom_base.push_back(T_odom_recorded * odometry.poses[k].T);
  }
  writeFileAtomically(folder / "times.txt", times);
  writeFileAtomically(folder / "poses.txt", formatKitti(half.T_world_base));
  writeFileAtomically(folder / "odometry.txt", formatKitti(T_odom_base));
  RunOptions options;
  options.input = folder.string();
  options.output = half.folder;
  options.quiet = true;
  options.sets = {"odometry.frontend=poses", "odometry.poses.file=\"" + (folder / "odometry.txt").string() + "\""};
  runJob(options, context(2));
  return half;
}

inline KittiHalves kittiHalves(const std::filesystem::path& recording, const std::filesystem::path& folder) {
  return {kittiHalf(recording, 0, Pose::Identity(), folder / "even"),
          kittiHalf(recording, 1, poseFromYaw(2.1, {340, -120, 3}), folder / "odd")};
}

}  // namespace scslam::test
