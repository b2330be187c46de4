// A small session with everything in it, told to a writer event by event.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "scslam/session/session_graph.h"
#include "scslam/session/session_writer.h"

namespace scslam::test {

struct MadeUpSession {
  std::size_t scan_count = 24;
  int scans_per_keyframe = 3;
  SessionInfo info;

  MadeUpSession() {
    info.input = "made up";
    info.input_format = "test";
    info.input_digest = "0123";
    info.config_yaml = "voxel_m: 0.5\nname: \"a: b\"\n";
    info.odometry = "o";
    info.recogniser = "r";
    info.registration = "g";
    info.sensor_label = "label \"with\" quotes\\";
    info.T_base_sensor = poseFromYaw(0.3, {0.1, -0.2, 1.7});
  }

  /// A circle of radius 10 m, driven once and a half, drifting.
  Pose odometryAt(std::size_t i) const {
    const double a = 0.4 * static_cast<double>(i);
    return poseFromYaw(a + 0.001 * static_cast<double>(i), {10 * std::sin(a), 10 - 10 * std::cos(a), 0.01 * a});
  }
  Cloud cloudOf(std::size_t k) const {
    Cloud cloud;
    for (std::size_t i = 0; i < 20 + k; ++i) {
      cloud.push(static_cast<float>(i) / 3, static_cast<float>(k), std::sin(static_cast<float>(i)));
      cloud.intensity.push_back(static_cast<float>(i * k) / 7);
    }
    return cloud;
  }
  Descriptor descriptorOf(std::size_t k) const {
    Descriptor d(3, 4);
    for (int i = 0; i < 12; ++i) d(i / 4, i % 4) = static_cast<float>(i) / (3 + static_cast<float>(k));
    return d;
  }

  /// Tells events first … to the writer; after each, `after(event number)`. A checkpoint follows every 7th scan.
  /// The "pipeline" keeps its state in nothing but the number of the next scan and the poses.
  void tell(
      SessionWriter& writer, std::size_t first_scan, std::vector<Keyframe> keyframes, std::vector<Pose> poses,
      std::vector<LoopRecord> loops, const std::function<void()>& after = [] {}) const {
    const auto per_keyframe = static_cast<std::size_t>(scans_per_keyframe);
    for (std::size_t i = first_scan; i < scan_count; ++i) {
      const bool is_keyframe = i % per_keyframe == 0;
      writer.addScan({i, stampFromSeconds(1e9 + 0.1 * static_cast<double>(i)), odometryAt(i),
                      static_cast<std::int64_t>(i / per_keyframe)});
      after();
      if (is_keyframe) {
        addKeyframe(writer, i, keyframes, poses);
        after();
        addLoop(writer, keyframes, poses, loops, after);
      }
      writer.logLine("scan " + std::to_string(i));
      after();
      if (i % 7 == 6) {
        writer.checkpoint(std::to_string(i + 1));
        after();
      }
    }
    writer.writeMetrics("{}\n");
    writer.finish(buildGraph(keyframes, loops, poses, false));
    writer.seal();
  }
  void tellAll(
      SessionWriter& writer, const std::function<void()>& after = [] {}) const {
    tell(writer, 0, {}, {}, {}, after);
  }

 private:
  void addKeyframe(SessionWriter& writer, std::size_t i, std::vector<Keyframe>& keyframes,
                   std::vector<Pose>& poses) const {
    Keyframe keyframe;
    keyframe.id = static_cast<KeyframeId>(keyframes.size());
    keyframe.scan_index = i;
    keyframe.stamp = stampFromSeconds(1e9 + 0.1 * static_cast<double>(i));
    keyframe.T_odom_base = odometryAt(i);
    keyframe.travelled_m = 4.0 * static_cast<double>(i);
    if (keyframe.id > 0) {
      keyframe.step_covariance = 1e-4 * Matrix6d::Identity();
      keyframe.step_passing << 1e-4, 2e-4, 3e-4, 4e-6, 5e-6, 6e-6 * keyframe.id;
    }
    const Pose T_map_odom = poses.empty() ? Pose::Identity() : poses.back() * keyframes.back().T_odom_base.inverse();
    keyframes.push_back(keyframe);
    poses.push_back(T_map_odom * keyframe.T_odom_base);
    writer.addKeyframe(keyframe, poses.back(), cloudOf(keyframe.id), descriptorOf(keyframe.id));
  }
  static void addLoop(SessionWriter& writer, const std::vector<Keyframe>& keyframes, std::vector<Pose>& poses,
                      std::vector<LoopRecord>& loops, const std::function<void()>& after) {
    if (keyframes.size() < 6) return;
    LoopRecord loop;
    loop.query = keyframes.back().id;
    loop.match = loop.query - 5;
    loop.recogniser = "r";
    loop.registered = true;
    loop.accepted = loop.query % 2 == 1;
    loop.reason = loop.accepted ? "accepted" : "overlap 0.1 < 0.3, too \"little\"";
    loop.T_match_query = poses[loop.match].inverse() * poses[loop.query];
    loop.information = 100 * Matrix6d::Identity();
    writer.addLoop(loop);
    loops.push_back(loop);
    after();
    if (!loop.accepted) return;
    for (std::size_t k = 0; k < poses.size(); ++k) poses[k].translation().z() -= 1e-3 * static_cast<double>(k);
    writer.setPoses(poses);
    after();
  }
};

}  // namespace scslam::test
