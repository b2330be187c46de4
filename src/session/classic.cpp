// Folders that the original saver wrote: poses, times and scans, no manifest and no journal.
#include <cmath>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/graph/g2o.h"
#include "scslam/session/layout.h"
#include "scslam/session/session.h"

namespace scslam {
namespace fs = std::filesystem;
namespace {

std::vector<Pose> readPoses(const fs::path& file) {
  const Trajectory trajectory = readTrajectory(file);
  if (trajectory.timed) throw inputError("{}: 12 numbers a line are expected (row-major 3x4)", file.string());
  std::vector<Pose> poses;
  for (const StampedPose& pose : trajectory.poses) poses.push_back(pose.T);
  return poses;
}

std::vector<Stamp> readTimes(const fs::path& file) {
  const std::string text = readFile(file);
  std::vector<Stamp> times;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string word = text.substr(begin, end - begin);
    begin = end + 1;
    word.erase(word.find_last_not_of(" \t\r") + 1);
    if (word.empty()) continue;
    if (Stamp stamp; parseStamp(word, stamp))
      times.push_back(stamp);
    else
      throw inputError("{}:{}: '{}' is not a time in seconds", file.string(), times.size() + 1, word);
  }
  return times;
}

/// The edges between keyframes that do not follow each other; the original marks loops in no other way.
std::vector<LoopRecord> readLoops(const fs::path& file, std::size_t keyframes) {
  std::vector<LoopRecord> loops;
  for (const Factor& factor : readG2o(file).graph.factors) {
    if (std::max(factor.i, factor.j) >= keyframes || factor.i == factor.j) continue;
    const bool forward = factor.i < factor.j;
    LoopRecord loop;
    loop.match = std::min(factor.i, factor.j);
    loop.query = std::max(factor.i, factor.j);
    if (loop.query - loop.match == 1) continue;
    loop.registered = loop.accepted = true;
    loop.reason = "accepted";
    loop.T_match_query = forward ? factor.T_i_j : factor.T_i_j.inverse();
    const Matrix6d J = adjoint(factor.T_i_j.inverse());  // T Exp(d) inverted = T^-1 Exp(-adjoint(T) d)
    loop.information = forward ? factor.information : Matrix6d(J.transpose() * factor.information * J);
    loops.push_back(loop);
  }
  return loops;
}

}  // namespace

void Session::openClassic() {
  for (const char* name : {layout::kTimes, layout::kScans})
    if (!fs::exists(folder_ / name))
      throw inputError("{} is no session: {} is there but {} is missing", folder_.string(), layout::kOptimisedPoses,
                       name);
  classic_ = complete_ = true;
  info_.input = folder_.string();
  info_.input_format = "classic session";
  T_map_base_ = readPoses(folder_ / layout::kOptimisedPoses);
  const std::vector<Stamp> times = readTimes(folder_ / layout::kTimes);
  // A classic session that was killed has fewer poses than times, or fewer times than poses: what has both counts.
  T_map_base_.resize(std::min(T_map_base_.size(), times.size()));
  std::vector<Pose> T_odom_base = T_map_base_;
  if (fs::exists(folder_ / layout::kOdometryPoses)) {
    T_odom_base = readPoses(folder_ / layout::kOdometryPoses);
    if (T_odom_base.size() < T_map_base_.size())
      throw inputError("{} has {} poses, {} has {}", (folder_ / layout::kOdometryPoses).string(), T_odom_base.size(),
                       layout::kOptimisedPoses, T_map_base_.size());
  }
  double travelled_m = 0;
  for (std::size_t k = 0; k < T_map_base_.size(); ++k) {
    if (k > 0) travelled_m += (T_odom_base[k].translation() - T_odom_base[k - 1].translation()).norm();
    Keyframe keyframe;
    keyframe.id = static_cast<KeyframeId>(k);
    keyframe.scan_index = k;
    keyframe.stamp = times[k];
    keyframe.T_odom_base = T_odom_base[k];
    keyframe.travelled_m = travelled_m;
    keyframes_.push_back(keyframe);
    scans_.push_back({k, times[k], T_odom_base[k], static_cast<std::int64_t>(k)});
  }
  if (fs::exists(folder_ / layout::kPoseGraph)) loops_ = readLoops(folder_ / layout::kPoseGraph, keyframes_.size());
}

}  // namespace scslam
