// Sessions of drives through made-up towns, each in a frame of its own; made once per process.
#pragma once
#include <map>

#include "scslam/apps/run_job.h"
#include "session/memory_folder.h"
#include "support/support.h"
#include "support/town.h"

namespace scslam::test {

struct TownSession {
  std::filesystem::path folder, input, truth;
  std::vector<Pose> T_world_base;
};

/// Mapped with the drifting odometry of the drive, which begins at T_odom_world's idea of the world.
inline TownSession townSession(const std::string& name, const Town& town, const std::vector<Pose>& truth,
                               const Pose& T_odom_world, const std::vector<std::string>& sets = {}) {
  static const std::filesystem::path root = memoryFolder() / "towns";
  TownSession session{root / name, root / (name + "-input"), root / (name + "-input") / "poses.txt", truth};
  std::vector<Pose> odometry = withDrift(truth, 0.05, 1.002);
  for (Pose& T : odometry) T = T_odom_world * T;
  writeKittiDrive(session.input, town, truth, odometry);
  RunOptions options;
  options.input = session.input.string();
  options.output = session.folder;
  options.quiet = true;
  options.sets = {"odometry.frontend=poses",
                  "odometry.poses.file=\"" + (session.input / "odometry.txt").string() + "\""};
  options.sets.insert(options.sets.end(), sets.begin(), sets.end());
  runJob(options, context(2));
  return session;
}

/// Three drives: two through one town, from different places and in unrelated frames, and one through another town.
struct ThreeDrives {
  TownSession first, second, elsewhere;
};
inline const ThreeDrives& threeDrives() {
  static const ThreeDrives drives = [] {
    const auto block = aroundTheBlock(1.5, 1.0);
    std::vector<Pose> later = aroundTheBlock(1.7, 1.0);
    later.erase(later.begin(), later.begin() + 20);
    for (Pose& T : later) T = T * poseFromYaw(0.05, {0, 0.4, 0});
    std::vector<Pose> street = outAndBack(40, 1.5);
    street.resize(26);
    return ThreeDrives{townSession("first", Town(1), block, Pose::Identity()),
                       townSession("second", Town(1), later, poseFromYaw(2.0, {300, -50, 4})),
                       townSession("elsewhere", Town(9), street, poseFromYaw(-1.0, {7, 7, 0}))};
  }();
  return drives;
}

}  // namespace scslam::test
