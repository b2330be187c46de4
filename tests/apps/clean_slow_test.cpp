// Cleaning of simulated traffic and of real recordings.
#include <octomap/octomap.h>

#include <cstring>
#include <iostream>

#include "apps/session_of.h"
#include "scslam/apps/clean/clean.h"
#include "scslam/apps/clean/clean_score.h"
#include "scslam/core/bytes.h"
#include "scslam/core/file.h"
#include "scslam/core/trajectory.h"
#include "support/simulated_drive.h"

namespace scslam::test {
namespace {

namespace fs = std::filesystem;

CleanSummary clean(const fs::path& session, const fs::path& labels, const fs::path& output,
                   LabelStyle style = LabelStyle::kSemanticKitti) {
  CleanOptions options;
  options.session = session, options.labels = labels, options.output = output;
  options.label_style = style;
  options.quiet = true;
  return cleanSession(options, context(2));
}

/// A scenario's whole drive among moving cars and people, mapped without dropping a point.
CleanSummary cleanedDrive(const std::string& name, const fs::path& folder) {
  simulateDrive(sim::loadScenario(name, {"truth.pictures=false", "truth.labels=true"}), folder);
  mapDrive(folder, {},
           {"preprocess.min_range_m=0", "preprocess.max_range_m=1000", "odometry.voxel_icp.max_range_m=1000"});
  return clean(folder / "session", folder / "drive.labels", folder / "clean");
}

TEST(CleanSimulated, TrafficGoesAndTheTownStays) {
  for (const char* name : {"s09_open_field", "s05_junction_grid"}) {
    const CleanSummary summary = cleanedDrive(name, freshFolder() / name);
    std::cout << name << "\n" << cleanTable(summary);
    const CleanScore& score = summary.score.value();
    EXPECT_GE(score.aa(), 0.97) << name;
    EXPECT_GE(score.pr(), 0.97) << name;
    EXPECT_GE(score.rr(), 0.97) << name;
  }
}

Cloud kittiCloud(const fs::path& file) {
  const std::string bytes = readFile(file);
  Cloud cloud;
  for (std::size_t at = 0; at + 16 <= bytes.size(); at += 16) {
    float value[4];
    std::memcpy(value, &bytes[at], 16);
    cloud.push(value[0], value[1], value[2]);
    cloud.intensity.push_back(value[3]);
  }
  return cloud;
}

/// All rays inserted, what is occupied in the end kept.
CleanScore plainOctoMap(const std::vector<Cloud>& clouds, const std::vector<Pose>& poses, const TrueLabels& labels) {
  octomap::OcTree tree(0.2);
  for (std::size_t k = 0; k < clouds.size(); ++k) {
    octomap::Pointcloud points;
    const Cloud cloud_map = transformed(clouds[k], poses[k]);
    for (std::size_t i = 0; i < cloud_map.size(); ++i) points.push_back(cloud_map.x[i], cloud_map.y[i], cloud_map.z[i]);
    const Eigen::Vector3d from = poses[k].translation();
    tree.insertPointCloud(points, octomap::point3d(static_cast<float>(from.x()), static_cast<float>(from.y()),
                                                   static_cast<float>(from.z())));
  }
  CleanScorer scorer;
  for (std::size_t k = 0; k < clouds.size(); ++k) {
    const Cloud cloud_map = transformed(clouds[k], poses[k]);
    std::vector<std::uint8_t> dynamic(cloud_map.size());
    for (std::size_t i = 0; i < cloud_map.size(); ++i) {
      const octomap::OcTreeNode* node = tree.search(cloud_map.x[i], cloud_map.y[i], cloud_map.z[i]);
      dynamic[i] = node == nullptr || !tree.isNodeOccupied(node) ? 1 : 0;
    }
    scorer.add(cloud_map, labels.of(k, cloud_map.size()), dynamic);
  }
  return scorer.score();
}

TEST(CleanReal, PandaSetIsCleanedBetterThanByAPlainOctoMap) {
  SCSLAM_NEEDS_DATA(recording, "pandaset002_f60-70");
  const Trajectory trajectory = readTrajectory(recording / "poses.txt");
  SessionParts parts;
  std::vector<Cloud> clouds;
  for (std::size_t k = 0; k < trajectory.poses.size(); ++k) {
    parts.odometry.push_back(trajectory.poses[k].T);
    clouds.push_back(kittiCloud(recording / "velodyne" / fmt::format("{:06}.bin", 60 + k)));
  }
  parts.optimised = parts.odometry;
  parts.cloud_sensor = [&clouds](std::size_t k) { return clouds[k]; };
  const fs::path folder = freshFolder();
  sessionOf(folder / "session", parts);
  const CleanSummary ours = clean(folder / "session", recording / "labels", folder / "clean", LabelStyle::kPandaSet);
  const CleanScore plain =
      plainOctoMap(clouds, parts.odometry, TrueLabels(recording / "labels", LabelStyle::kPandaSet));
  std::cout << cleanTable(ours)
            << fmt::format("plain OctoMap: SA {:.4f} DA {:.4f} AA {:.4f} PR {:.4f} RR {:.4f}\n", plain.sa(), plain.da(),
                           plain.aa(), plain.pr(), plain.rr());
  EXPECT_GT(ours.score->aa(), plain.aa() + 0.05);
  EXPECT_GT(ours.score->sa(), 0.97);
}

TEST(CleanReal, AClassicSessionOfScALoamIsCleaned) {
  SCSLAM_NEEDS_DATA(session, "scaloam_session_Seosan01");
  const CleanSummary summary = clean(session, {}, freshFolder() / "clean");
  std::cout << cleanTable(summary);
  EXPECT_EQ(summary.keyframes, 21u);
  EXPECT_GT(summary.removed, 1000u);
  EXPECT_LT(static_cast<double>(summary.removed), 0.05 * static_cast<double>(summary.points));
}

}  // namespace
}  // namespace scslam::test
