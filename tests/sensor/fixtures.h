// Tiny inputs of every registered format, written by the tests themselves.
#pragma once
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/maps/CPointsMapXYZI.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/serialization/CArchive.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "radar_fixtures.h"
#include "scslam/core/mrpt_pose.h"
#include "scslam/core/pcd.h"
#include "scslam/core/trajectory.h"
#include "scslam/sensor/scan_source.h"
#include "support/support.h"

namespace scslam::test {

namespace fs = std::filesystem;

/// Without the fsync of the real thing: there are thousands of them.
inline void writeBytes(const fs::path& file, const std::string& bytes) {
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << bytes;
}
inline std::string readBytes(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Scan i of every fixture: taken at fixtureStamp(i), points fixtureCloud(i), at fixturePose(i) in odom.
constexpr std::size_t kFixtureScans = 6;
inline Stamp fixtureStamp(std::size_t i) {
  return stampFromNanoseconds(1561000444000000000 + 100000000 * static_cast<std::int64_t>(i));
}
inline Pose fixturePose(std::size_t i) {
  return poseFromYaw(0.01 * static_cast<double>(i), {0.5 * static_cast<double>(i), 0, 0});
}
inline Cloud fixtureCloud(std::size_t i) {
  Cloud cloud;
  for (int k = 0; k < 64; ++k) {
    cloud.push(5.F + static_cast<float>(i), static_cast<float>(k) * 0.25F, -1.F);
    cloud.intensity.push_back(static_cast<float>(k));
  }
  return cloud;
}

inline std::string encodeXyzi(const Cloud& cloud) {
  std::string bytes(cloud.size() * 16, '\0');
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float p[4] = {cloud.x[i], cloud.y[i], cloud.z[i], cloud.intensity[i]};
    std::memcpy(bytes.data() + 16 * i, p, 16);
  }
  return bytes;
}

inline mrpt::obs::CObservationPointCloud::Ptr pointCloudObservation(const Cloud& cloud, Stamp stamp) {
  auto map = mrpt::maps::CPointsMapXYZI::Create();
  for (std::size_t k = 0; k < cloud.size(); ++k) {
    map->insertPointFast(cloud.x[k], cloud.y[k], cloud.z[k]);
    map->setPointIntensity(k, cloud.intensity[k]);
  }
  auto observation = mrpt::obs::CObservationPointCloud::Create();
  observation->pointcloud = map;
  observation->timestamp = stamp;
  observation->sensorLabel = "lidar";
  observation->sensorPose = mrpt::poses::CPose3D(0.1, 0, 1.5, 0, 0, 0);
  return observation;
}

/// Objects to a rawlog; level 0 writes a plain file.
inline void writeRawlog(const fs::path& file, const std::vector<mrpt::serialization::CSerializable::Ptr>& objects,
                        int level) {
  fs::create_directories(file.parent_path());
  const fs::path packed = file.string() + ".gz";
  {
    mrpt::io::CFileGZOutputStream out;
    ASSERT_TRUE(out.open(packed.string(), std::max(level, 1)));
    auto archive = mrpt::serialization::archiveFrom(out);
    for (const auto& object : objects) archive << *object;
  }
  if (level != 0) {
    fs::rename(packed, file);
    return;
  }
  ASSERT_EQ(std::system(("gzip -dc '" + packed.string() + "' > '" + file.string() + "'").c_str()), 0);
  fs::remove(packed);
}

/// Six clouds with a CObservationRobotPose in the middle between them, so that scans lie between two poses.
inline std::vector<mrpt::serialization::CSerializable::Ptr> rawlogObjects() {
  std::vector<mrpt::serialization::CSerializable::Ptr> objects;
  for (std::size_t i = 0; i < kFixtureScans; ++i) {
    const auto pose = [&](double part) {
      auto observation = mrpt::obs::CObservationRobotPose::Create();
      observation->timestamp = fixtureStamp(i) + std::chrono::milliseconds(static_cast<int>(100 * part));
      observation->pose.mean = toMrpt(interpolate(fixturePose(i), fixturePose(i + 1), part));
      return observation;
    };
    if (i == 0) objects.push_back(pose(-0.5));
    objects.push_back(pointCloudObservation(fixtureCloud(i), fixtureStamp(i)));
    objects.push_back(pose(0.5));
  }
  return objects;
}

/// One input per registered format; `damage` is the file of it that holds the last scan (or all of them).
struct Fixture {
  std::string format;
  fs::path uri, damage;
};

inline bool isRadarFormat(const std::string& format) {
  return format == "oxford_radar" || format == "mulran_radar" || format == "radiate";
}

inline std::string globalPoseRow(std::size_t i) {
  std::string row = fmt::format("{}", 1561000444000000000 + 100000000 * static_cast<std::int64_t>(i));
  Pose T = fixturePose(i);
  T.translation() += Eigen::Vector3d(350000, 4000000, 20);
  for (int k = 0; k < 12; ++k) row += fmt::format(",{:.17g}", T.matrix()(k / 4, k % 4));
  return row + "\n";
}

inline Fixture makeRadarFixture(const std::string& format, const fs::path& folder) {
  std::string truth = "source_timestamp,destination_timestamp,x,y,z,roll,pitch,yaw\n", poses, times;
  fs::path last;
  for (std::size_t i = 0; i < kFixtureScans; ++i) {
    const auto us = [](std::size_t k) { return 1561000444000000 + 100000 * static_cast<std::int64_t>(k); };
    const RadarScan sweep = fixtureSweep(i, fixtureStamp(i));
    if (format == "oxford_radar") {
      last = folder / "radar" / fmt::format("{}.png", us(i));
      writeBytes(last, encodeOxfordRadar(sweep));
      if (i == 0) continue;
      const Pose T = fixturePose(i - 1).inverse() * fixturePose(i);  // x forward, y right, z down
      truth += fmt::format("{},{},{:.17g},{:.17g},0,0,0,{:.17g}\n", us(i), us(i - 1), T.translation().x(),
                           -T.translation().y(), -yawOf(T));
    } else if (format == "mulran_radar") {
      last = folder / "sensor_data/radar/polar_oxford_form" / fmt::format("{}000.png", us(i) + 250000);
      writeBytes(last, encodeOxfordRadar(sweep));
      poses += globalPoseRow(i);
    } else {
      last = folder / "Navtech_Polar" / fmt::format("{:06d}.png", i + 1);
      writeBytes(last, encodeColumns(sweep));  // the last of 8 azimuths is 218.75 ms after the first
      times += fmt::format("Frame: {:06d} Time: {}.{:09d}\n", i + 1, 1561000444, 100000000 * i + 218750000);
    }
  }
  if (format == "oxford_radar") writeBytes(folder / "gt/radar_odometry.csv", truth);
  if (format == "mulran_radar") writeBytes(folder / "global_pose.csv", poses);
  if (format == "radiate") writeBytes(folder / "Navtech_Polar.txt", times);
  return {format, folder, last};
}

inline void PrintTo(const Fixture& fixture, std::ostream* out) { *out << fixture.format << " at " << fixture.uri; }

inline Fixture makeFixture(const std::string& format, const fs::path& folder) {
  if (isRadarFormat(format)) return makeRadarFixture(format, folder);
  std::vector<Pose> poses;
  std::string times;
  for (std::size_t i = 0; i < kFixtureScans; ++i) {
    poses.push_back(fixturePose(i));
    times += formatStamp(fixtureStamp(i)) + "\n";
  }
  const std::string last = fmt::format("{:06d}", kFixtureScans - 1);
  const auto scans = [&](const fs::path& sub, const char* extension, auto encode) {
    for (std::size_t i = 0; i < kFixtureScans; ++i)
      writeBytes(folder / sub / fmt::format("{:06d}{}", i, extension), encode(fixtureCloud(i)));
  };
  if (format == "rawlog") {
    writeRawlog(folder / "a.rawlog", rawlogObjects(), 1);
    return {format, folder / "a.rawlog", folder / "a.rawlog"};
  }
  if (format == "kitti") {
    scans("velodyne", ".bin", encodeXyzi);
    writeBytes(folder / "times.txt", times);
    writeBytes(folder / "poses.txt", formatKitti(poses));
    writeBytes(folder / "odometry.txt", formatKitti(poses));
    return {format, folder, folder / "velodyne" / (last + ".bin")};
  }
  if (format == "mulran") {
    std::string table;
    for (std::size_t i = 0; i < kFixtureScans; ++i) {
      const auto ns = fmt::format("{}", 1561000444000000000 + 100000000 * static_cast<std::int64_t>(i));
      writeBytes(folder / "Ouster" / (ns + ".bin"), encodeXyzi(fixtureCloud(i)));
      table += globalPoseRow(i);
    }
    writeBytes(folder / "global_pose.csv", table);
    return {format, folder, folder / "Ouster" / "1561000444500000000.bin"};
  }
  if (format == "session") {
    scans("Scans", ".pcd", encodePcd);
    writeBytes(folder / "times.txt", times);
    writeBytes(folder / "odom_poses.txt", formatKitti(poses));
    writeBytes(folder / "optimized_poses.txt", formatKitti(poses));
    return {format, folder, folder / "Scans" / (last + ".pcd")};
  }
  scans("", ".pcd", encodePcd);
  writeBytes(folder / "times.txt", times);
  writeBytes(folder / "poses.txt", formatKitti(poses));
  return {format, folder, folder / (last + ".pcd")};
}

inline OpenedSource openQuietly(const fs::path& uri, const OpenOptions& options = {}) {
  return openSource(uri, context(), options);
}

/// All scans up to the clean end. Throws what next() throws.
inline std::vector<Scan> readAll(ScanSource& source) {
  std::vector<Scan> scans;
  while (auto scan = source.next()) scans.push_back(std::move(*scan));
  return scans;
}

inline std::string messageOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput) << error.what();
    return error.what();
  }
  return "";
}

}  // namespace scslam::test
