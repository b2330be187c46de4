// A radar sweep through a rawlog, whole and damaged.
#include "scslam/sensor/radar_observation.h"

#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/io/CFileOutputStream.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/serialization/CArchive.h>
#include <sys/resource.h>

#include <fstream>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/sensor/rawlog_objects.h"
#include "support/support.h"

namespace scslam {
namespace {

namespace fs = std::filesystem;

RadarScan aScan() {
  RadarScan scan;
  scan.resize(20, 300);
  for (std::size_t i = 0; i < scan.azimuths; ++i) {
    scan.stamps[i] = stampFromNanoseconds(1547131046353776100 + 625000 * static_cast<std::int64_t>(i));
    scan.angles[i] = 0.1 * static_cast<double>(i);
    for (std::size_t k = 0; k < scan.bins; ++k) scan.row(i)[k] = static_cast<std::uint8_t>(i * 31 + k * k);
  }
  scan.valid[3] = 0;
  scan.range_resolution_m = 0.0432, scan.range_offset_m = -0.31, scan.doppler_beta_s = 0.049;
  scan.label = "navtech";
  scan.T_base_sensor = poseFromYaw(0.3, {1.5, -0.04, 1.97});
  return scan;
}

template <class Stream>
void writeObjects(Stream&& out, const RadarScan& scan) {
  auto archive = mrpt::serialization::archiveFrom(out);
  mrpt::obs::CObservationComment comment;
  comment.text = "after it";
  archive << CObservationRadar(scan) << comment;
}

void writeRawlog(const fs::path& file, const RadarScan& scan, bool packed) {
  if (packed)
    writeObjects(mrpt::io::CFileGZOutputStream(file.string()), scan);
  else
    writeObjects(mrpt::io::CFileOutputStream(file.string()), scan);
}

TEST(RadarObservation, SurvivesARawlog) {
  const RadarScan scan = aScan();
  const auto file = scslam::test::freshFolder() / "radar.rawlog";
  for (const bool packed : {false, true}) {
    writeRawlog(file, scan, packed);
    EXPECT_EQ(RawlogObjects::firstClassName(file), "scslam::CObservationRadar");
    RawlogObjects objects(file);
    const auto object = objects.next();
    const auto* read = dynamic_cast<const CObservationRadar*>(object.get());
    ASSERT_NE(read, nullptr);
    EXPECT_EQ(read->timestamp, scan.stamps[0]);
    EXPECT_EQ(read->sensorLabel, "navtech");
    EXPECT_EQ(read->scan.label, "navtech");
    EXPECT_EQ(read->scan.azimuths, scan.azimuths);
    EXPECT_EQ(read->scan.bins, scan.bins);
    EXPECT_EQ(read->scan.power, scan.power);
    EXPECT_EQ(read->scan.stamps, scan.stamps);
    EXPECT_EQ(read->scan.angles, scan.angles);
    EXPECT_EQ(read->scan.valid, scan.valid);
    EXPECT_EQ(read->scan.range_resolution_m, scan.range_resolution_m);
    EXPECT_EQ(read->scan.range_offset_m, scan.range_offset_m);
    EXPECT_EQ(read->scan.doppler_beta_s, scan.doppler_beta_s);
    EXPECT_EQ(read->scan.T_base_sensor.matrix(), scan.T_base_sensor.matrix());
    EXPECT_NE(dynamic_cast<const mrpt::obs::CObservationComment*>(objects.next().get()), nullptr);
    EXPECT_EQ(objects.next(), nullptr);
  }
}

TEST(RadarObservation, FilesFromBeforeTheDopplerFactorAreStillRead) {
  const auto file = scslam::test::freshFolder() / "radar.rawlog";
  const RadarScan scan = aScan();
  writeRawlog(file, scan, false);
  std::string bytes = readFile(file);
  const std::string name = "scslam::CObservationRadar";
  const std::size_t version = bytes.find(name) + name.size();
  ASSERT_EQ(bytes.at(version), 1);
  bytes[version] = 0;
  const std::string factor(reinterpret_cast<const char*>(&scan.doppler_beta_s), sizeof(double));
  bytes.erase(bytes.find(factor), factor.size());
  std::ofstream(file, std::ios::binary) << bytes;
  RawlogObjects objects(file);
  const auto object = objects.next();
  const auto* read = dynamic_cast<const CObservationRadar*>(object.get());
  ASSERT_NE(read, nullptr);
  EXPECT_EQ(read->scan.doppler_beta_s, 0);
  EXPECT_EQ(read->scan.power, scan.power);
}

TEST(RadarObservation, PoseOfTheSensorIsMrpts) {
  CObservationRadar observation(aScan());
  mrpt::poses::CPose3D pose;
  observation.getSensorPose(pose);
  EXPECT_NEAR(pose.yaw(), 0.3, 1e-12);
  observation.setSensorPose(mrpt::poses::CPose3D(1, 2, 3, 0.1, 0, 0));
  EXPECT_THAT(observation.scan.T_base_sensor, scslam::test::IsNear(poseFromYaw(0.1, {1, 2, 3}), 1e-12, 1e-9));
  EXPECT_NE(observation.asString().find("20 azimuths x 300 bins"), std::string::npos);
}

/// Reads to the end. @return what is wrong, empty when nothing.
std::string readThrough(const fs::path& file) {
  try {
    RawlogObjects objects(file);
    while (objects.next()) {
    }
    return "";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    return error.what();
  }
}

TEST(RadarObservation, DamageIsOneLineAndNeverACrash) {
  const auto file = scslam::test::freshFolder() / "radar.rawlog";
  writeRawlog(file, aScan(), false);
  const std::string good = readFile(file);
  const auto write = [&](const std::string& bytes) { std::ofstream(file, std::ios::binary) << bytes; };
  for (std::size_t cut = 30; cut < 6000; cut += 149) {
    write(good.substr(0, cut));
    EXPECT_NE(readThrough(file), "") << cut;
  }
  for (std::size_t at = 0; at < 400; ++at) {  // the head and the first row
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 0xFF);
    write(bad);
    EXPECT_EQ(readThrough(file).find('\n'), std::string::npos);
  }
}

TEST(RadarObservation, SizesBeyondTheFileOrReasonAreRefusedBeforeMemoryIsTaken) {
  const auto file = scslam::test::freshFolder() / "radar.rawlog";
  writeRawlog(file, aScan(), false);
  const std::string good = readFile(file);
  const std::string sizes("\x14\0\0\0\x2c\x01\0\0", 8);  // 20 x 300
  const std::size_t at = good.find(sizes);
  ASSERT_NE(at, std::string::npos);
  const auto peakMegabytes = [] {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss / 1024;
  };
  const auto before = peakMegabytes();
  for (const std::string& stated : {std::string("\x14\0\0\0\x2c\x01\0\x01", 8),  // 20 x 16777516
                                    std::string("\0\x30\0\0\0\x80\0\0", 8),      // 12288 x 32768
                                    std::string("\xff\xff\xff\xff\xff\xff\xff\xff", 8)}) {
    std::string bad = good;
    bad.replace(at, 8, stated);
    std::ofstream(file, std::ios::binary) << bad;
    EXPECT_THAT(readThrough(file), testing::HasSubstr("CObservationRadar"));
  }
  EXPECT_LT(peakMegabytes() - before, 100);
}

TEST(RadarObservation, ScansWithoutMeaningAreNotKept) {
  RadarScan scan = aScan();
  scan.range_resolution_m = 0;
  EXPECT_THROW(CObservationRadar{scan}, Error);
  scan = aScan();
  scan.angles.pop_back();
  EXPECT_THROW(CObservationRadar{scan}, Error);
  scan = aScan();
  scan.T_base_sensor.linear() *= 2;
  EXPECT_THROW(CObservationRadar{scan}, Error);
}

}  // namespace
}  // namespace scslam
