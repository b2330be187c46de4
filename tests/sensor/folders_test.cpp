// The folder layouts: times, poses, frames.
#include <fstream>

#include "fixtures.h"
#include "scslam/sensor/scan_files.h"

namespace scslam {
namespace {

using test::fixtureCloud;
using test::fixtureStamp;
using test::writeBytes;
using testing::HasSubstr;
namespace fs = std::filesystem;

TEST(ScanFiles, SortNaturally) {
  EXPECT_TRUE(naturallyLess("scan2.pcd", "scan10.pcd"));
  EXPECT_FALSE(naturallyLess("scan10.pcd", "scan2.pcd"));
  EXPECT_TRUE(naturallyLess("a007", "a8"));
  EXPECT_TRUE(naturallyLess("a", "a1"));
  EXPECT_FALSE(naturallyLess("a1", "a1"));
}

TEST(ScanFiles, NamesAreTimesByTheirMagnitude) {
  const Stamp stamp = stampFromNanoseconds(1561000444390857600);
  EXPECT_EQ(stampOfName("1561000444390857600.bin"), stamp);
  EXPECT_EQ(stampOfName("1561000444390857.bin"), stampFromNanoseconds(1561000444390857000));
  EXPECT_EQ(stampOfName("1561000444.3908576.pcd"), stamp);
  EXPECT_FALSE(stampOfName("000042.pcd"));
  EXPECT_FALSE(stampOfName("0000000000000042.pcd"));
  EXPECT_FALSE(stampOfName("map_final.pcd"));
}

fs::path kittiFolder(const std::vector<int>& numbers) {
  const auto folder = test::freshFolder();
  for (const int i : numbers)
    writeBytes(folder / "velodyne" / fmt::format("{:06d}.bin", i), test::encodeXyzi(fixtureCloud(0)));
  return folder;
}

std::vector<double> secondsOf(const fs::path& folder) {
  std::vector<double> seconds;
  for (const Scan& scan : test::readAll(*test::openQuietly(folder).source)) seconds.push_back(toSeconds(scan.stamp));
  return seconds;
}

TEST(Kitti, TimesByOrderWhenThereAreAsManyRows) {
  const auto folder = kittiFolder({60, 62, 69});
  writeBytes(folder / "times.txt", "1.5\n2.5\n3e0\n");
  EXPECT_EQ(secondsOf(folder), (std::vector<double>{1.5, 2.5, 3}));
}

TEST(Kitti, TimesByFileNumberWhenScansAreMissing) {
  const auto folder = kittiFolder({1, 3});
  writeBytes(folder / "times.txt", "0.0\n0.1\n0.2\n0.5\n0.6\n");
  EXPECT_EQ(secondsOf(folder), (std::vector<double>{0.1, 0.5}));
}

TEST(Kitti, TimesOfTwoColumnsGoByTheFirst) {
  const auto folder = kittiFolder({60, 62});
  writeBytes(folder / "times.txt", "60 10\n61 11\n62 12.25\n");
  EXPECT_EQ(secondsOf(folder), (std::vector<double>{10, 12.25}));
}

TEST(Kitti, TimesOfACalendar) {
  const auto folder = kittiFolder({0});
  writeBytes(folder / "times.txt", "2011-09-26 13:02:25.500000000\n");
  EXPECT_EQ(secondsOf(folder), (std::vector<double>{1317042145.5}));
}

TEST(Kitti, TimesThatDoNotFitAreAnErrorWithBothCounts) {
  const auto folder = kittiFolder({0, 7});
  writeBytes(folder / "times.txt", "0\n1\n2\n");
  EXPECT_THAT(test::messageOf([&] { test::openQuietly(folder); }), HasSubstr("times.txt has 3 rows for 2 scans"));
  writeBytes(folder / "times.txt", "0\nnoon\n");
  EXPECT_THAT(test::messageOf([&] { test::openQuietly(folder); }), HasSubstr("times.txt:2: 'noon' is not a time"));
}

TEST(Kitti, WithoutTimesTheNumbersCountAtTenHertzAndThatIsSaid) {
  const auto folder = kittiFolder({2, 5});
  EXPECT_EQ(secondsOf(folder), (std::vector<double>{0.2, 0.5}));
  EXPECT_THAT(test::openQuietly(folder).source->description(), HasSubstr("made up"));
}

TEST(Kitti, CameraPosesAreTakenToTheLidar) {
  const auto folder = kittiFolder({0, 1});
  // Camera: x right, y down, z forward. LiDAR: x forward, y left, z up; 0.3 m behind the camera.
  writeBytes(folder / "calib.txt", "P0: 1 0 0 0 0 1 0 0 0 0 1 0\nTr: 0 -1 0 0  0 0 -1 0  1 0 0 -0.3\n");
  writeBytes(folder / "times.txt", "0\n0.1\n");
  writeBytes(folder / "poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 2\n");  // 2 m along z: forward
  const auto source = test::openQuietly(folder).source;
  const auto truth = source->groundTruth();
  ASSERT_TRUE(truth);
  EXPECT_THAT(truth->poses[1].T, test::IsNear(poseFromYaw(0, {2, 0, 0}), 1e-9, 1e-6));
  const Eigen::Vector3d camera_in_base = source->T_base_reference() * Eigen::Vector3d::Zero();
  EXPECT_LT((camera_in_base - Eigen::Vector3d(0.3, 0, 0)).norm(), 1e-12);
}

TEST(Kitti, PosesLieWhereTheBenchmarkPutsThem) {
  const auto root = test::freshFolder();
  writeBytes(root / "sequences/07/velodyne/000000.bin", test::encodeXyzi(fixtureCloud(0)));
  writeBytes(root / "poses/07.txt", "1 0 0 5 0 1 0 0 0 0 1 0\n");
  EXPECT_TRUE(test::openQuietly(root / "sequences/07").source->groundTruth());
  EXPECT_TRUE(test::openQuietly(root / "sequences/07/").source->groundTruth()) << "with a slash at the end";
}

TEST(Mulran, LooksBackwardsHasRingsAndTimes) {
  const auto fixture = test::makeFixture("mulran", test::freshFolder());
  const auto source = test::openQuietly(fixture.uri).source;
  const Scan scan = *source->next();
  EXPECT_LT((scan.T_base_sensor * Eigen::Vector3d(1, 0, 0)).x(), 1.0) << "the LiDAR's x points backwards";
  ASSERT_TRUE(scan.cloud.hasRing() && scan.cloud.hasTime());
  EXPECT_EQ(scan.cloud.ring[63], 63);
  EXPECT_THAT(source->description(), HasSubstr("350000.000 4000000.000 20.000"));
}

TEST(Clouds, OtherTextFilesDoNotDisturb) {
  const auto folder = test::freshFolder();
  for (const int i : {2, 10, 1})
    writeBytes(folder / fmt::format("{}.pcd", i), encodePcd(fixtureCloud(static_cast<std::size_t>(i))));
  writeBytes(folder / "icp_odometry_reference.txt", "what ever\n");
  writeBytes(folder / "poses.txt", "1 0 0 5 0 1 0 0 0 0 1 0\n");  // one row for three scans
  const auto source = test::openQuietly(folder).source;
  EXPECT_THAT(source->description(), HasSubstr("poses.txt not used"));
  EXPECT_FALSE(source->groundTruth());
  const auto scans = test::readAll(*source);
  ASSERT_EQ(scans.size(), 3U);
  EXPECT_EQ(scans[2].cloud.x[0], fixtureCloud(10).x[0]) << "10 comes after 2";
}

TEST(Clouds, ReadsPlyAsciiAndBinaryWithPropertiesInAnyOrder) {
  const auto folder = test::freshFolder();
  const std::string head =
      "element vertex 2\nproperty uchar ring\nproperty double z\nproperty float y\nproperty float x\n"
      "property ushort intensity\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n";
  std::string binary = "ply\nformat binary_little_endian 1.0\ncomment hello\n" + head;
  for (int i = 0; i < 2; ++i) {
    const double z = 3 + i;
    const float y = 2, x = 1;
    const std::uint16_t intensity = 300;
    binary += static_cast<char>(i);
    binary.append(reinterpret_cast<const char*>(&z), 8).append(reinterpret_cast<const char*>(&y), 4);
    binary.append(reinterpret_cast<const char*>(&x), 4).append(reinterpret_cast<const char*>(&intensity), 2);
  }
  writeBytes(folder / "1.ply", "ply\nformat ascii 1.0\n" + head + "0 3 2 1 300\n1 4 2 1 300\n");
  writeBytes(folder / "2.ply", binary);
  for (const Scan& scan : test::readAll(*test::openQuietly(folder).source)) {
    EXPECT_EQ(scan.cloud.x, (std::vector<float>{1, 1}));
    EXPECT_EQ(scan.cloud.z, (std::vector<float>{3, 4}));
    EXPECT_EQ(scan.cloud.intensity, (std::vector<float>{300, 300}));
    EXPECT_EQ(scan.cloud.ring, (std::vector<std::uint16_t>{0, 1}));
  }
  for (std::size_t cut = 0; cut + 1 < binary.size(); cut += 3) {
    writeBytes(folder / "2.ply", binary.substr(0, cut));
    EXPECT_THAT(test::messageOf([&] { test::readAll(*test::openQuietly(folder).source); }), HasSubstr("2.ply")) << cut;
  }
}

TEST(Clouds, ReadsXyzTextAndSingleFiles) {
  const auto folder = test::freshFolder();
  writeBytes(folder / "a.xyz", "# x y z\n1 2 3 4\n5,6,7,8\n");
  const auto scans = test::readAll(*test::openQuietly(folder / "a.xyz").source);
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_EQ(scans[0].cloud.y, (std::vector<float>{2, 6}));
  EXPECT_EQ(scans[0].cloud.intensity, (std::vector<float>{4, 8}));
  writeBytes(folder / "a.xyz", "1 2 3\n1 2\n");
  EXPECT_THAT(test::messageOf([&] { test::readAll(*test::openQuietly(folder).source); }),
              HasSubstr("a.xyz:2: 2 columns"));
}

TEST(Session, OursHasTheSensorsPlaceOnTheRobot) {
  const auto fixture = test::makeFixture("session", test::freshFolder());
  writeBytes(fixture.uri / "session.yaml", "T_base_sensor: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 2]\nplanar: false\n");
  const Scan scan = *test::openQuietly(fixture.uri).source->next();
  EXPECT_DOUBLE_EQ(scan.T_base_sensor.translation().z(), 2);
  EXPECT_DOUBLE_EQ(scan.T_odom_base->translation().z(), -2) << "the files hold poses of the sensor";
  writeBytes(fixture.uri / "session.yaml", "T_base_sensor: [1, 2]\n");
  EXPECT_THAT(test::messageOf([&] { test::openQuietly(fixture.uri); }), HasSubstr("has 2 numbers, not 12"));
}

TEST(Session, OfAKilledSaverEndsWithItsPoses) {
  const auto fixture = test::makeFixture("session", test::freshFolder());
  writeBytes(fixture.uri / "odom_poses.txt", formatKitti({test::fixturePose(0), test::fixturePose(1)}));
  const auto source = test::openQuietly(fixture.uri).source;
  EXPECT_EQ(source->size(), 2U);
  EXPECT_THAT(source->description(), HasSubstr("4 scans without a row in odom_poses.txt left out"));
}

TEST(RealData, EverySharedFolderOpens) {
  SCSLAM_NEEDS_DATA(pandaset, "pandaset002_f60-70");
  const auto check = [](const fs::path& uri, const char* format, std::size_t scans, bool truth, bool odometry) {
    const auto opened = test::openQuietly(uri);
    EXPECT_EQ(opened.format, format);
    EXPECT_EQ(opened.source->size(), scans);
    EXPECT_EQ(opened.source->groundTruth().has_value(), truth);
    const auto scan = opened.source->next();
    ASSERT_TRUE(scan);
    EXPECT_GT(scan->cloud.size(), 50'000U);
    EXPECT_EQ(scan->T_odom_base.has_value(), odometry);
  };
  const auto data = pandaset.parent_path();
  check(pandaset, "kitti", 11, true, false);
  check(data / "kitti_raw_2011_09_26_f00-21", "clouds", 22, false, false);
  check(data / "kitti00_kf000-039", "clouds", 40, true, false);
  check(data / "scaloam_session_Seosan01", "session", 21, false, true);
}

}  // namespace
}  // namespace scslam
