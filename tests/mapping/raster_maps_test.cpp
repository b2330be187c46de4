// The exporters whose maps are pictures: what stands where, in metres.
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/serialization/CArchive.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "apps/session_of.h"
#include "odometry/radar_drive.h"
#include "scslam/apps/run_job.h"
#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/grey_png.h"
#include "scslam/mapping/map_builder.h"
#include "scslam/sensor/radar_observation.h"
#include "session/memory_folder.h"
#include "support/support.h"

namespace scslam::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// A picture with its world file: grey levels by map coordinates.
class RasterMap {
 public:
  explicit RasterMap(const fs::path& png) : image_(decodeGreyPng(readFile(png), png.string())) {
    fs::path world = png;
    std::istringstream in(readFile(world.replace_extension(".pgw")));
    double zero_a = 0, zero_b = 0, down = 0;
    in >> cell_m_ >> zero_a >> zero_b >> down >> x0_ >> y0_;
    EXPECT_TRUE(in && zero_a == 0 && zero_b == 0 && down == -cell_m_);
  }
  double cell() const { return cell_m_; }
  /// -1 outside of the picture.
  int at(double x, double y) const {
    const double column = std::round((x - x0_) / cell_m_), row = std::round((y0_ - y) / cell_m_);
    if (column < 0 || row < 0 || column >= static_cast<double>(image_.columns) ||
        row >= static_cast<double>(image_.rows))
      return -1;
    return image_.pixels[static_cast<std::size_t>(row) * image_.columns + static_cast<std::size_t>(column)];
  }

 private:
  GreyImage image_;
  double cell_m_ = 0, x0_ = 0, y0_ = 0;
};

constexpr int kUnknown = 205, kSurelyFree = 220, kSurelyOccupied = 60;

/// A wall at x = 8.05 from y = -3 to 3 and, 2 m above the sensor, a sign at x = 4, seen from six places.
SessionParts wallAndSign(bool planar) {
  SessionParts parts;
  parts.planar = planar;
  for (int k = 0; k < 6; ++k) parts.optimised.push_back(poseFromYaw(0.1 * k, {0.3 * k, 0.1 * k, 0}));
  parts.odometry = parts.optimised;
  parts.cloud_sensor = [poses = parts.optimised, planar](std::size_t k) {
    Cloud cloud;
    for (int i = -60; i <= 60; ++i) cloud.push(8.05f, 0.05f * static_cast<float>(i), 0);
    for (int i = -5; i <= 5 && !planar; ++i) cloud.push(4.0f, 0.05f * static_cast<float>(i), 2);
    transformInPlace(cloud, poses[k].inverse());
    return cloud;
  };
  return parts;
}

TEST(GridMap, IsFreeUpToTheWallAndUnknownBehindIt) {
  for (const bool planar : {false, true}) {
    const fs::path folder = memoryFolder();
    exportMap(sessionOf(folder / "s", wallAndSign(planar)), {"grid"}, {}, folder / "map", context());
    const RasterMap map(folder / "map" / "grid.png");
    EXPECT_DOUBLE_EQ(map.cell(), 0.2);
    for (const double y : {-2.5, 0.0, 2.5}) {
      EXPECT_LT(map.at(8.05, y), kSurelyOccupied) << y;
      EXPECT_GT(map.at(7.5, y), kSurelyFree) << y;
    }
    EXPECT_GT(map.at(4.0, 0), kSurelyFree) << "what hangs above the band is not in the way";
    for (const double x : {8.5, 9.0}) EXPECT_TRUE(map.at(x, 0) == kUnknown || map.at(x, 0) == -1);
    EXPECT_TRUE(map.at(2, -3) == kUnknown || map.at(2, -3) == -1) << "no ray went there";
    EXPECT_THAT(readFile(folder / "map" / "grid.yaml"), HasSubstr("resolution: 0.2"));
  }
}

TEST(GridMap, TakesTheCellThatIsAskedFor) {
  const fs::path folder = memoryFolder();
  MapOptions options;
  options.voxel_m = 0.5;
  exportMap(sessionOf(folder / "s", wallAndSign(true)), {"grid"}, options, folder / "map", context());
  EXPECT_DOUBLE_EQ(RasterMap(folder / "map" / "grid.png").cell(), 0.5);
}

TEST(GridMap, WithoutAnObstacleThereIsNone) {
  const fs::path folder = memoryFolder();
  SessionParts parts = wallAndSign(false);
  parts.cloud_sensor = [](std::size_t) {
    Cloud cloud;
    for (int i = 0; i < 50; ++i) cloud.push(3, 0.1f * static_cast<float>(i), 5);
    return cloud;
  };
  EXPECT_THROW(exportMap(sessionOf(folder / "s", parts), {"grid"}, {}, folder / "map", context()), Error);
}

const Vector6d kTwist = (Vector6d() << 1.5, 0, 0, 0, 0, 0.3).finished();
const Pose kStart = poseFromYaw(0.2, {-3, -3, 0});

/// A session of a drive through the room, its sweeps in a rawlog beside it.
Session driveThroughTheRoom(const fs::path& folder) {
  RadarSensor sensor;
  sensor.sweep_s = 0.25, sensor.doppler_beta_s = 0.049;
  {
    mrpt::io::CFileGZOutputStream file((folder / "drive.rawlog").string());
    auto archive = mrpt::serialization::archiveFrom(file);
    Pose T = kStart;
    for (std::size_t k = 0; k < 10; ++k, T = retract(T, sensor.sweep_s * kTwist))
      archive << CObservationRadar(*radarAt(k, T, roomWorld(), sensor, kTwist).radar);
  }
  RunOptions options;
  options.input = (folder / "drive.rawlog").string();
  options.configs = {"radar"};
  options.sets = {"preprocess.min_range_m=0.5", "radar.k_strongest.min_range_m=0.5"};
  options.output = folder / "s";
  options.quiet = true;
  runJob(options, context());
  return Session::open(folder / "s");
}

TEST(RadarPowerMap, ShowsAWallWhereItStands) {
  const fs::path folder = memoryFolder();
  const Session session = driveThroughTheRoom(folder);
  MapOptions options;
  options.voxel_m = 0.1;
  exportMap(session, {"radar_power"}, options, folder / "map", context(2));
  const RasterMap map(folder / "map" / "radar_power.png");
  const auto power = [&](double x, double y) {
    const Eigen::Vector3d p = kStart.inverse() * Eigen::Vector3d(x, y, 0);
    return static_cast<double>(map.at(p.x(), p.y()));
  };
  double on = 0, before = 0, behind = 0;
  int n = 0;
  for (double x = -5; x <= 8; x += 0.1, ++n) on += power(x, -6), before += power(x, -5.4), behind += power(x, -6.6);
  EXPECT_GT(on / n, 60) << "of 255 for the strongest";
  EXPECT_LT(before / n, 0.1 * on / n);
  EXPECT_LT(behind / n, 0.1 * on / n);
  EXPECT_THAT(readFile(folder / "map" / "radar_power.yaml"), HasSubstr("resolution: 0.1"));
}

TEST(RadarPowerMap, EndsWhereItsRangeEnds) {
  const fs::path folder = memoryFolder();
  const Session session = driveThroughTheRoom(folder);
  MapOptions options;
  options.max_range_m = 4;
  exportMap(session, {"radar_power"}, options, folder / "near", context(2));
  exportMap(session, {"radar_power"}, {}, folder / "all", context(2));
  const auto bytes = [&folder](const char* map) { return fs::file_size(folder / map / "radar_power.png"); };
  EXPECT_LT(2 * bytes("near"), bytes("all"));
}

TEST(RadarPowerMap, NeedsTheImages) {
  const fs::path folder = memoryFolder();
  const Session session = driveThroughTheRoom(folder);
  fs::remove(folder / "drive.rawlog");
  try {
    exportMap(session, {"radar_power"}, {}, folder / "map", context());
    FAIL() << "made a map of nothing";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    EXPECT_THAT(error.what(), HasSubstr("drive.rawlog"));
  }
}

}  // namespace
}  // namespace scslam::test
