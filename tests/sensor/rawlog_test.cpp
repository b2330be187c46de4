// Every observation class, written by the test and read back exactly; poses; the recordings that ship with MRPT.
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/system/filesystem.h>

#include <algorithm>
#include <cmath>

#include "fixtures.h"
#include "scslam/sensor/pose_track.h"
#include "scslam/sensor/sensor_tables.h"

namespace scslam {
namespace {

using mrpt::poses::CPose3D;
using test::fixtureStamp;
using testing::HasSubstr;
using Objects = std::vector<mrpt::serialization::CSerializable::Ptr>;
namespace fs = std::filesystem;

std::unique_ptr<ScanSource> sourceOf(const Objects& objects, int level = 1, const OpenOptions& options = {}) {
  const auto file = test::freshFolder() / "a.rawlog";
  test::writeRawlog(file, objects, level);
  return test::openQuietly(file, options).source;
}

mrpt::obs::CObservation2DRangeScan::Ptr laserScan(std::size_t i, const std::string& label = "laser") {
  auto scan = mrpt::obs::CObservation2DRangeScan::Create();
  scan->timestamp = fixtureStamp(i);
  scan->sensorLabel = label;
  scan->aperture = static_cast<float>(M_PI);
  scan->maxRange = 80;
  scan->sensorPose = CPose3D(0.3, 0, 0.2, 0, 0, M_PI);  // upside down
  const float ranges[5] = {1, 2, 3, 4, 5};
  const char valid[5] = {1, 1, 0, 1, 1};
  scan->loadFromVectors(5, ranges, valid);
  return scan;
}

mrpt::obs::CObservationOdometry::Ptr wheels(double after_s, double x) {
  auto odometry = mrpt::obs::CObservationOdometry::Create();
  odometry->timestamp = fixtureStamp(0) + std::chrono::microseconds(static_cast<int>(after_s * 1e6));
  odometry->odometry = mrpt::poses::CPose2D(x, 0, 0);
  return odometry;
}

TEST(Rawlog, LaserScanIsAPlanarCloudOfItsValidRays) {
  const auto source = sourceOf({laserScan(0)});
  EXPECT_TRUE(source->planar());
  const Scan scan = *source->next();
  EXPECT_TRUE(scan.planar);
  EXPECT_EQ(scan.label, "laser");
  ASSERT_EQ(scan.cloud.size(), 4U) << "the ray marked invalid is left out";
  EXPECT_NEAR(scan.cloud.y[0], -1, 1e-6) << "right to left: the first ray looks to -90 deg";
  EXPECT_NEAR(scan.cloud.x[2], 4 * std::sqrt(0.5), 1e-5);
  EXPECT_EQ(scan.cloud.z, (std::vector<float>(4, 0.F)));
  EXPECT_FALSE(scan.cloud.hasTime());
  EXPECT_NEAR((scan.T_base_sensor * Eigen::Vector3d(0, 1, 0)).y(), -1, 1e-9) << "mounted upside down";
}

TEST(Rawlog, LaserFromLeftToRightIsMirrored) {
  auto scan = laserScan(0);
  scan->rightToLeft = false;
  EXPECT_NEAR(sourceOf({scan})->next()->cloud.y[0], 1, 1e-6);
}

TEST(Rawlog, PointCloudKeepsPointsIntensityAndPose) {
  for (const int level : {0, 1, 6}) {
    const Scan scan = *sourceOf({test::pointCloudObservation(test::fixtureCloud(3), fixtureStamp(3))}, level)->next();
    EXPECT_EQ(scan.cloud.x, test::fixtureCloud(3).x);
    EXPECT_EQ(scan.cloud.intensity, test::fixtureCloud(3).intensity);
    EXPECT_EQ(scan.stamp, fixtureStamp(3));
    EXPECT_THAT(scan.T_base_sensor, test::IsNear(poseFromYaw(0, {0.1, 0, 1.5}), 1e-9, 1e-6));
    EXPECT_FALSE(scan.planar);
  }
}

TEST(Rawlog, PointCloudsMayLieInFilesBesideIt) {
  using Format = mrpt::obs::CObservationPointCloud::ExternalStorageFormat;
  const auto folder = test::freshFolder();
  const Cloud cloud = test::fixtureCloud(1);
  auto observation = test::pointCloudObservation(cloud, fixtureStamp(0));
  auto binary = test::pointCloudObservation(cloud, fixtureStamp(1));
  test::writeRawlog(folder / "a_Images" / "cloud.mrpt", {observation->pointcloud}, 1);
  test::writeBytes(folder / "cloud.bin", test::encodeXyzi(cloud));
  observation->pointcloud.reset(), binary->pointcloud.reset();
  observation->setAsExternalStorage("cloud.mrpt", Format::MRPT_Serialization);
  binary->setAsExternalStorage("cloud.bin", Format::KittiBinFile);
  test::writeRawlog(folder / "a.rawlog", {observation, binary}, 1);
  for (const Scan& scan : test::readAll(*test::openQuietly(folder / "a.rawlog").source))
    EXPECT_EQ(scan.cloud.intensity, cloud.intensity);
  fs::remove(folder / "cloud.bin");
  EXPECT_THAT(test::messageOf([&] { test::readAll(*test::openQuietly(folder / "a.rawlog").source); }),
              HasSubstr("cloud.bin that it refers to is not there"));
}

mrpt::obs::CObservationVelodyneScan::Ptr velodyneScan() {
  auto scan = mrpt::obs::CObservationVelodyneScan::Create();
  scan->timestamp = fixtureStamp(0);
  scan->sensorLabel = "velodyne";
  auto& cloud = scan->point_cloud;
  for (int i = 0; i < 20; ++i) {
    cloud.x.push_back(static_cast<float>(i)), cloud.y.push_back(1), cloud.z.push_back(-1);
    cloud.intensity.push_back(static_cast<std::uint8_t>(i));
    cloud.timestamp.push_back(fixtureStamp(0) + std::chrono::milliseconds(5 * i));
    cloud.azimuth.push_back(0);
    cloud.laser_id.push_back(static_cast<std::int16_t>(i % 4));
  }
  return scan;
}

TEST(Rawlog, VelodyneScanKeepsTimeRingAndIntensity) {
  const Cloud cloud = sourceOf({velodyneScan()})->next()->cloud;
  ASSERT_EQ(cloud.size(), 20U);
  EXPECT_EQ(cloud.intensity[7], 7);
  EXPECT_EQ(cloud.ring[7], 3);
  EXPECT_FLOAT_EQ(cloud.dt[7], 0.035F);
}

TEST(Rawlog, VelodyneScanWithListsOfDifferentLengthIsRefused) {
  auto scan = velodyneScan();
  scan->point_cloud.laser_id.pop_back();
  const auto source = sourceOf({scan, velodyneScan()});
  EXPECT_THAT(test::messageOf([&] { source->next(); }), HasSubstr("a.rawlog: scan 0: a Velodyne scan's lists"));
  EXPECT_FALSE(source->next());
}

TEST(Rawlog, RotatingScanIsUnfoldedByTheSensorTable) {
  auto image = mrpt::obs::CObservationRotatingScan::Create();
  image->timestamp = fixtureStamp(0);
  image->sensorLabel = "ring";
  image->rowCount = 64, image->columnCount = 8;
  image->rangeImage.setZero(64, 8);
  image->rangeImage(63, 2) = 5000;
  image->rangeResolution = 0.002;
  image->startAzimuth = 0, image->azimuthSpan = 2 * M_PI;  // counter-clockwise
  image->sweepDuration = 0.1;
  image->lidarModel = "something";
  EXPECT_THAT(test::messageOf([&] { sourceOf({image}); }), HasSubstr("1 x CObservationRotatingScan 'ring'"));
  OpenOptions options;
  options.sensor = loadSensorModel("os1-64");
  const Cloud cloud = sourceOf({image}, 1, options)->next()->cloud;
  ASSERT_EQ(cloud.size(), 1U);
  EXPECT_NEAR(cloud.y[0], 10 * std::cos(16.611 * M_PI / 180), 1e-4) << "column 2 of 8: to the left";
  EXPECT_NEAR(cloud.z[0], 10 * std::sin(16.611 * M_PI / 180), 1e-4);
  EXPECT_EQ(cloud.ring[0], 63);
  EXPECT_FLOAT_EQ(cloud.dt[0], 0.025F);
}

TEST(Rawlog, RobotPosesAreInterpolatedToTheScansStamp) {
  const auto scans = test::readAll(*sourceOf(test::rawlogObjects()));
  ASSERT_EQ(scans.size(), test::kFixtureScans);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    ASSERT_TRUE(scans[i].T_odom_base) << i;
    EXPECT_THAT(*scans[i].T_odom_base, test::IsNear(test::fixturePose(i), 1e-3, 0.1)) << i;
  }
}

TEST(Rawlog, WheelOdometryIsInterpolatedAndCarriedOnAtTheEnds) {
  const auto scans = test::readAll(
      *sourceOf({laserScan(0), wheels(0.05, 1.0), laserScan(1), wheels(0.15, 3.0), laserScan(2), laserScan(9)}));
  ASSERT_EQ(scans.size(), 4U);
  EXPECT_NEAR(scans[0].T_odom_base->translation().x(), 0.0, 1e-6);
  EXPECT_NEAR(scans[1].T_odom_base->translation().x(), 2.0, 1e-6);
  EXPECT_NEAR(scans[2].T_odom_base->translation().x(), 4.0, 1e-6);
  EXPECT_FALSE(scans[3].T_odom_base) << "0.75 s after the last pose nobody knows";
}

TEST(Rawlog, ActionsAreIntegrated) {
  Objects objects;
  for (std::size_t i = 0; i < 3; ++i) {
    auto actions = mrpt::obs::CActionCollection::Create();
    if (i < 2) {
      mrpt::obs::CActionRobotMovement2D action;
      action.computeFromOdometry(mrpt::poses::CPose2D(1, 0, M_PI / 2), {});
      actions->insert(action);
    } else {
      mrpt::obs::CActionRobotMovement3D action;
      action.poseChange.mean = CPose3D(0, 0, 0.5, 0, 0, 0);
      actions->insert(action);
    }
    auto frame = mrpt::obs::CSensoryFrame::Create();
    *frame += laserScan(i);
    objects.push_back(actions), objects.push_back(frame);
  }
  const auto source = sourceOf(objects);
  const auto scans = test::readAll(*source);
  ASSERT_EQ(scans.size(), 3U);
  EXPECT_THAT(*scans[0].T_odom_base, test::IsNear(poseFromYaw(M_PI / 2, {1, 0, 0}), 1e-9, 1e-6));
  EXPECT_THAT(*scans[1].T_odom_base, test::IsNear(poseFromYaw(M_PI, {1, 1, 0}), 1e-9, 1e-6));
  EXPECT_THAT(*scans[2].T_odom_base, test::IsNear(poseFromYaw(M_PI, {1, 1, 0.5}), 1e-9, 1e-6));
  EXPECT_THAT(source->description(), HasSubstr("from the actions"));
}

TEST(Rawlog, OfSeveralLabelsTheFirstOrTheNamedOneIsTaken) {
  const Objects objects = {mrpt::obs::CObservationComment::Create(), laserScan(0, "front"), laserScan(1, "rear"),
                           laserScan(2, "front")};
  const auto front = sourceOf(objects);
  EXPECT_EQ(test::readAll(*front).size(), 2U);
  EXPECT_THAT(front->description(), HasSubstr("not taken: 'rear'"));
  OpenOptions options;
  options.label = "rear";
  EXPECT_EQ(test::readAll(*sourceOf(objects, 1, options)).size(), 1U);
  options.label = "side";
  EXPECT_THAT(test::messageOf([&] { sourceOf(objects, 1, options); }),
              HasSubstr("no scans with the label 'side'; it holds 2 x CObservation2DRangeScan 'front', 1 x "
                        "CObservation2DRangeScan 'rear'"));
}

TEST(Rawlog, StampsThatGoBackArePassedOnAndMissingOnesMadeUp) {
  auto timeless = laserScan(0);
  timeless->timestamp = INVALID_TIMESTAMP;
  const auto source = sourceOf({laserScan(3), laserScan(1), laserScan(1), timeless});
  const auto scans = test::readAll(*source);
  ASSERT_EQ(scans.size(), 4U);
  EXPECT_EQ(scans[1].stamp, fixtureStamp(1));
  EXPECT_EQ(scans[2].stamp, fixtureStamp(1));
  EXPECT_NEAR(secondsBetween(scans[2].stamp, scans[3].stamp), 0.1, 1e-9);
  EXPECT_THAT(source->description(), HasSubstr("made up"));
}

TEST(Rawlog, TruthLiesBesideIt) {
  const auto file = test::freshFolder() / "a.rawlog";
  test::writeRawlog(file, test::rawlogObjects(), 1);
  test::writeBytes(file.parent_path() / "a.gt.tum", formatTum({{fixtureStamp(0), test::fixturePose(4)}}));
  const auto truth = test::openQuietly(file).source->groundTruth();
  ASSERT_TRUE(truth);
  EXPECT_THAT(truth->poses[0].T, test::IsNear(test::fixturePose(4), 1e-9, 1e-6));
}

TEST(PoseTrack, ForgetsNothingItStillNeeds) {
  PoseTrack track;
  for (std::size_t i = 0; i < 5; ++i) track.add(fixtureStamp(i), poseFromYaw(0, {static_cast<double>(i), 0, 0}));
  const Stamp between = fixtureStamp(2) + std::chrono::milliseconds(50);
  const auto before = track.at(between);
  track.forgetBefore(between);
  EXPECT_NEAR(track.at(between)->translation().x(), before->translation().x(), 0);
  EXPECT_NEAR(before->translation().x(), 2.5, 1e-9);
}

std::optional<fs::path> mrptDataset(const std::string& name) {
  const fs::path file = fs::path(mrpt::system::getShareMRPTDir()) / "datasets" / name;
  return fs::is_regular_file(file) ? std::optional(file) : std::nullopt;
}

TEST(Rawlog, PacketsOfAVlp16BecomeRingsFromTheLowest) {
  const auto file = mrptDataset("test_velodyne_VLP16.rawlog");
  if (!file) GTEST_SKIP() << "mrpt-common is not installed";
  const Scan scan = *test::openQuietly(*file).source->next();
  ASSERT_GT(scan.cloud.size(), 10'000U);
  for (std::size_t i = 0; i < scan.cloud.size(); i += 7) {
    const Eigen::Vector3f p = scan.cloud.point(i);
    const double elevation = std::asin(p.z() / p.norm()) * 180 / M_PI;
    ASSERT_NEAR(elevation, -15 + 2 * scan.cloud.ring[i], 0.2);
  }
  const auto [first, last] = std::minmax_element(scan.cloud.dt.begin(), scan.cloud.dt.end());
  EXPECT_EQ(*first, 0);
  EXPECT_NEAR(*last, 0.098, 0.002);
}

TEST(Rawlog, ARotatingScanOfAVlp16HasTheSamePointsAsItsPackets) {
  const auto packets = mrptDataset("test_velodyne_VLP16.rawlog"), image = mrptDataset("rot_scan_velodyne.rawlog");
  if (!packets || !image) GTEST_SKIP() << "mrpt-common is not installed";
  const Cloud a = test::openQuietly(*packets).source->next()->cloud,
              b = test::openQuietly(*image).source->next()->cloud;
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); i += 101) {
    double nearest = 1e9;
    for (std::size_t j = 0; j < b.size(); ++j)
      if (a.ring[i] == b.ring[j]) nearest = std::min<double>(nearest, (a.point(i) - b.point(j)).norm());
    EXPECT_LT(nearest, 0.02 + 0.006 * a.point(i).norm()) << "the image has one azimuth per column";
  }
}

TEST(Rawlog, RecordingsThatShipWithMrptRead) {
  SCSLAM_NEEDS_DATA(folder, "rawlogs");
  const auto count = [](const fs::path& file) {
    const auto source = test::openQuietly(file).source;
    EXPECT_TRUE(source->planar());
    std::size_t with_odometry = 0, scans = 0;
    for (; const auto scan = source->next(); ++scans) with_odometry += scan->T_odom_base.has_value();
    EXPECT_EQ(with_odometry, scans);
    return scans;
  };
  EXPECT_EQ(count(folder / "mit-csail.rawlog"), 1988U);
  EXPECT_EQ(count(folder / "ual_dataset_2014_05_23_2dlaser_odo.rawlog"), 3318U);
  EXPECT_THAT(test::messageOf([&] { test::openQuietly(folder / "test_rtk_path.rawlog"); }),
              HasSubstr("307 x CObservationGPS 'GPS_RTK_FRONT_L'"));
}

}  // namespace
}  // namespace scslam
