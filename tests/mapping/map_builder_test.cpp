#include "scslam/mapping/map_builder.h"

#include <octomap/OcTree.h>

#include <cstring>
#include <fstream>
#include <set>

#include "apps/session_of.h"
#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/pcd.h"
#include "scslam/graph/g2o.h"
#include "scslam/mapping/map_exporter.h"
#include "session/folder_bytes.h"
#include "session/memory_folder.h"
#include "support/support.h"

namespace scslam::test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Walls at x = 8 and y = -5 seen from five places along x, sensor 1 m over the base; each scan a square grid of
/// points.
SessionParts walls() {
  SessionParts parts;
  parts.T_base_sensor = poseFromYaw(0, {0, 0, 1});
  for (int k = 0; k < 5; ++k) parts.optimised.push_back(poseFromYaw(0.2 * k, {0.5 * k, 0, 0}));
  parts.odometry = parts.optimised;
  parts.cloud_sensor = [poses = parts.optimised, S = parts.T_base_sensor](std::size_t k) {
    Cloud cloud;
    for (int i = -20; i <= 20; ++i)
      for (int j = 0; j < 10; ++j) {
        cloud.push(8.02f, 0.1f * static_cast<float>(i), 0.1f * static_cast<float>(j));
        cloud.push(0.1f * static_cast<float>(i), -5.02f, 0.1f * static_cast<float>(j));
      }
    cloud.intensity.assign(cloud.size(), 7.0f);
    transformInPlace(cloud, (poses[k] * S).inverse());
    return cloud;
  };
  return parts;
}
constexpr std::size_t kPointsPerScan = 41 * 10 * 2;

std::vector<float> pointsOf(const std::string& file, const std::string& end_of_header) {
  const std::size_t begin = file.find(end_of_header) + end_of_header.size();
  std::vector<float> values((file.size() - begin) / 4);
  std::memcpy(values.data(), file.data() + begin, 4 * values.size());
  return values;
}

TEST(ExportMap, PlyAndPcdHoldEveryPointWhenNothingIsThinned) {
  const fs::path folder = memoryFolder();
  MapOptions options;
  options.voxel_m = 0;
  const MapSummary summary =
      exportMap(sessionOf(folder / "s", walls()), {"ply", "pcd"}, options, folder / "map", context());
  EXPECT_THAT(summary.files, ElementsAre(folder / "map/map.ply", folder / "map/map.pcd"));
  EXPECT_EQ(summary.points_written, 5 * kPointsPerScan);
  const std::string ply = readFile(folder / "map/map.ply");
  EXPECT_TRUE(ply.starts_with("ply\nformat binary_little_endian 1.0\n"));
  EXPECT_THAT(ply, HasSubstr("\nelement vertex 4100\nproperty float x\n"));
  const auto values = pointsOf(ply, "end_header\n");
  ASSERT_EQ(values.size(), 4 * 5 * kPointsPerScan);
  const Cloud pcd = readPcd(folder / "map/map.pcd");
  ASSERT_EQ(pcd.size(), 5 * kPointsPerScan);
  for (std::size_t i = 0; i < pcd.size(); ++i) {
    ASSERT_EQ(values[4 * i], pcd.x[i]);
    ASSERT_EQ(values[4 * i + 3], 7.0f);
    ASSERT_TRUE(std::abs(pcd.x[i] - 8.02f) < 1e-4 || std::abs(pcd.y[i] + 5.02f) < 1e-4) << pcd.point(i);
  }
}

TEST(ExportMap, KeepsOneMeasuredPointPerVoxel) {
  const fs::path folder = memoryFolder();
  MapOptions options;
  options.voxel_m = 0.25;
  const Session session = sessionOf(folder / "s", walls());
  const MapSummary summary = exportMap(session, {"pcd"}, options, folder / "map", context());
  const Cloud map = readPcd(folder / "map/map.pcd");
  std::set<std::array<int, 3>> voxels;
  for (std::size_t i = 0; i < map.size(); ++i)
    voxels.insert({static_cast<int>(std::floor(map.x[i] / 0.25)), static_cast<int>(std::floor(map.y[i] / 0.25)),
                   static_cast<int>(std::floor(map.z[i] / 0.25))});
  EXPECT_EQ(voxels.size(), map.size());
  EXPECT_EQ(summary.points_read, map.size() + summary.thinned);
  MapOptions all;
  all.voxel_m = 0;
  exportMap(session, {"pcd"}, all, folder / "all", context());
  const Cloud every = readPcd(folder / "all/map.pcd");
  std::set<std::array<int, 3>> occupied;
  for (std::size_t i = 0; i < every.size(); ++i)
    occupied.insert({static_cast<int>(std::floor(every.x[i] / 0.25)), static_cast<int>(std::floor(every.y[i] / 0.25)),
                     static_cast<int>(std::floor(every.z[i] / 0.25))});
  EXPECT_EQ(voxels, occupied);  // none lost
}

TEST(ExportMap, GivesTheSameBytesForAnyThreadsAndAnyBudget) {
  const fs::path folder = memoryFolder();
  const Session session = sessionOf(folder / "s", walls());
  MapOptions small;
  small.voxel_budget_bytes = 1;
  exportMap(session, {"ply", "octomap"}, {}, folder / "a", context(1));
  exportMap(session, {"ply", "octomap"}, small, folder / "b", context(4));
  EXPECT_EQ(bytesOf(folder / "a"), bytesOf(folder / "b"));
}

TEST(ExportMap, RangeLimitsAreCounted) {
  const fs::path folder = memoryFolder();
  MapOptions options;
  options.voxel_m = 0;
  options.max_range_m = 6;
  const MapSummary summary = exportMap(sessionOf(folder / "s", walls()), {"pcd"}, options, folder / "map", context());
  EXPECT_GT(summary.out_of_range, 0u);
  EXPECT_EQ(summary.points_written + summary.out_of_range, summary.points_read);
}

TEST(ExportMap, OctomapIsOccupiedAtTheWallAndFreeBeforeIt) {
  const fs::path folder = memoryFolder();
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  exportMap(sessionOf(folder / "s", walls()), {"octomap"}, {}, folder / "map", context());
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");  // the library likes to talk
  octomap::OcTree bt(0.1);
  ASSERT_TRUE(bt.readBinary((folder / "map/map.bt").string()));
  EXPECT_DOUBLE_EQ(bt.getResolution(), 0.2);
  std::unique_ptr<octomap::AbstractOcTree> ot(octomap::AbstractOcTree::read((folder / "map/map.ot").string()));
  ASSERT_NE(dynamic_cast<octomap::OcTree*>(ot.get()), nullptr);
  for (octomap::OcTree* tree : {&bt, dynamic_cast<octomap::OcTree*>(ot.get())}) {
    const auto at = [tree](double x, double y, double z) { return tree->search(x, y, z); };
    ASSERT_NE(at(8.02, 0, 0.5), nullptr);
    EXPECT_TRUE(tree->isNodeOccupied(at(8.02, 0, 0.5)));
    ASSERT_NE(at(4, 0, 0.8), nullptr);
    EXPECT_FALSE(tree->isNodeOccupied(at(4, 0, 0.8)));
    EXPECT_EQ(at(9, 0, 0.5), nullptr);  // behind the wall nothing is known
  }
}

TEST(ExportMap, OctomapOfAPlanarSensorIsOneCellHigh) {
  const fs::path folder = memoryFolder();
  SessionParts parts = walls();
  parts.planar = true;
  exportMap(sessionOf(folder / "s", parts), {"octomap"}, {}, folder / "map", context());
  octomap::OcTree tree(0.1);
  ASSERT_TRUE(tree.readBinary((folder / "map/map.bt").string()));
  double x, y, z;
  tree.getMetricSize(x, y, z);
  EXPECT_NEAR(z, 0.2, 1e-9);
}

TEST(ExportMap, OctomapBeyondItsKeysIsAnErrorNotAHole) {
  const fs::path folder = memoryFolder();
  SessionParts parts = walls();
  parts.optimised[4].translation().x() = 7000;
  EXPECT_THROW(exportMap(sessionOf(folder / "s", parts), {"octomap"}, {}, folder / "map", context()), Error);
  EXPECT_FALSE(fs::exists(folder / "map/map.bt"));
}

TEST(ExportMap, TrajectoriesAndGraphNeedNoScans) {
  const fs::path folder = memoryFolder();
  SessionParts parts = walls();
  parts.loops = {acceptedLoop(0, 4, parts.optimised[0].inverse() * parts.optimised[4])};
  const Session session = sessionOf(folder / "s", parts);
  fs::remove_all(folder / "s/Scans");
  const MapSummary summary = exportMap(session, {"tum", "kitti", "g2o"}, {}, folder / "map", context());
  EXPECT_EQ(summary.points_read, 0u);
  for (const char* name : {"trajectory.tum", "trajectory.kitti.txt"}) {
    const Trajectory trajectory = readTrajectory(folder / "map" / name);
    ASSERT_EQ(trajectory.poses.size(), 5u);
    EXPECT_THAT(trajectory.poses[3].T, IsNear(parts.optimised[3], 1e-12, 1e-9));
  }
  const PoseGraph graph = readG2o(folder / "map/posegraph.g2o").graph;
  EXPECT_EQ(graph.factors.size(), 5u);
  EXPECT_THAT(graph.poses[4], IsNear(parts.optimised[4], 1e-9, 1e-6));
}

TEST(ExportMap, UnknownFormatIsAUsageErrorBeforeAnythingIsWritten) {
  const fs::path folder = memoryFolder();
  const Session session = sessionOf(folder / "s", walls());
  try {
    exportMap(session, {"ply", "plx"}, {}, folder / "map", context());
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(static_cast<int>(error.code()), 2);
    EXPECT_THAT(error.what(), HasSubstr("octomap"));
  }
  EXPECT_FALSE(fs::exists(folder / "map"));
}

TEST(ExportMap, DamagedScanLeavesNoHalfMap) {
  const fs::path folder = memoryFolder();
  const Session session = sessionOf(folder / "s", walls());
  fs::resize_file(folder / "s/Scans/000003.pcd", 1000);
  EXPECT_THROW(exportMap(session, {"ply", "pcd"}, {}, folder / "map", context()), Error);
  EXPECT_TRUE(bytesOf(folder / "map").empty());
}

TEST(ExportMap, ClassicFolderWithLostScansGivesWhatThereIs) {
  SCSLAM_NEEDS_DATA(data, "scaloam_session_Seosan01");
  const fs::path folder = memoryFolder();
  const MapSummary summary = exportMap(Session::open(data), {"ply"}, {}, folder, context(2));
  EXPECT_EQ(summary.missing_scans, 2878u - 21u);
  EXPECT_GT(summary.points_written, 100000u);
}

TEST(ExportVerb, SaysWhereTheMapIs) {
  const fs::path folder = memoryFolder();
  sessionOf(folder / "s", walls());
  const RunResult run = runScslam("export " + (folder / "s").string() + " --format ply,tum -q");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(run.out.ends_with("map: " + (folder / "s/map").string() + "\n")) << run.out;
  const RunResult wrong = runScslam("export " + (folder / "s").string() + " --format obj");
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("ply"));
}

TEST(MapExporters, AreTheseAndNoneVanishes) {
  EXPECT_THAT(Registry<MapExporter>::instance().names(),
              ElementsAre("g2o", "grid", "kitti", "octomap", "pcd", "ply", "radar_power", "tum"));
}

}  // namespace
}  // namespace scslam::test
