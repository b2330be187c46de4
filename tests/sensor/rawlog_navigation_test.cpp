// Inertial and satellite readings of a rawlog: each scan gets its own, once, however the file is read.
#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <cmath>

#include "fixtures.h"

namespace scslam {
namespace {

using mrpt::poses::CPose3D;
using test::fixtureStamp;
using testing::HasSubstr;
using Objects = std::vector<mrpt::serialization::CSerializable::Ptr>;

std::unique_ptr<ScanSource> sourceOf(const Objects& objects) {
  const auto file = test::freshFolder() / "a.rawlog";
  test::writeRawlog(file, objects, 1);
  return test::openQuietly(file).source;
}

mrpt::obs::CObservation::Ptr scanAt(std::size_t i) {
  return test::pointCloudObservation(test::fixtureCloud(i), fixtureStamp(i));
}

Stamp after(double seconds) { return fixtureStamp(0) + std::chrono::microseconds(std::llround(seconds * 1e6)); }

mrpt::obs::CObservationOdometry::Ptr wheels(double after_s, double x) {
  auto odometry = mrpt::obs::CObservationOdometry::Create();
  odometry->timestamp = after(after_s);
  odometry->odometry = mrpt::poses::CPose2D(x, 0, 0);
  return odometry;
}

mrpt::obs::CObservationIMU::Ptr imuAt(double after_s, const std::string& label = "imu") {
  using namespace mrpt::obs;
  auto imu = CObservationIMU::Create();
  imu->timestamp = after(after_s);
  imu->sensorLabel = label;
  imu->sensorPose = CPose3D(0.2, 0, 0.1, M_PI / 2, 0, 0);
  imu->set(IMU_WX, 0.1), imu->set(IMU_WY, 0.2), imu->set(IMU_WZ, after_s);
  imu->set(IMU_X_ACC, 1), imu->set(IMU_Y_ACC, 2), imu->set(IMU_Z_ACC, 9.8);
  return imu;
}

/// Scans every 0.1 s with an IMU of 100 Hz whose readings lie `behind_s` later in the file than their time says.
Objects withImu(double behind_s) {
  Objects objects;
  for (int i = -5; i < 90; ++i) {
    const double file_s = 0.01 * i;
    if (i >= 0 && i < 60 && i % 10 == 0) objects.push_back(scanAt(static_cast<std::size_t>(i / 10)));
    objects.push_back(imuAt(file_s - behind_s));
  }
  return objects;
}

TEST(RawlogNavigation, EachScanGetsTheImuReadingsUpToTheNextOne) {
  for (const double behind_s : {0.0, 0.033, 0.25}) {
    const auto source = sourceOf(withImu(behind_s));
    const auto scans = test::readAll(*source);
    ASSERT_EQ(scans.size(), 6U);
    std::size_t handed = 0;
    for (std::size_t k = 0; k < scans.size(); ++k) {
      handed += scans[k].imu.size();
      if (k + 1 == scans.size()) continue;
      ASSERT_FALSE(scans[k].imu.empty()) << k;
      EXPECT_GE(scans[k].imu.back().stamp, fixtureStamp(k + 1)) << behind_s;
      EXPECT_LT(secondsBetween(fixtureStamp(k + 1), scans[k].imu.back().stamp), 0.0101) << "only the first beyond";
      if (k > 0) {
        EXPECT_NEAR(secondsBetween(scans[k - 1].imu.back().stamp, scans[k].imu.front().stamp), 0.01, 1e-6);
      }
    }
    EXPECT_EQ(handed, 95U) << "each once";
    EXPECT_THAT(source->description(), HasSubstr("imu 'imu'"));
    EXPECT_NEAR(scans[0].T_base_imu.linear()(1, 0), 1, 1e-9);
    const ImuSample& sample = scans[1].imu.front();
    EXPECT_EQ(sample.gyro_rad_s.x(), 0.1) << "MRPT numbers the rates z, y, x";
    EXPECT_EQ(sample.gyro_rad_s.y(), 0.2);
    EXPECT_EQ(sample.accel_m_s2, Eigen::Vector3d(1, 2, 9.8));
  }
}

TEST(RawlogNavigation, SkippingAndTakingHandOverTheSameReadings) {
  Objects objects = withImu(0.12);
  for (std::size_t i = 0; i < 6; ++i)
    objects.insert(objects.begin() + static_cast<long>(9 * i), wheels(0.1 * static_cast<double>(i), 1.0));
  const auto taken = test::readAll(*sourceOf(objects));
  for (std::size_t n = 1; n < 6; ++n) {
    const auto source = sourceOf(objects);
    source->skip(n);
    const auto rest = test::readAll(*source);
    ASSERT_EQ(rest.size(), 6 - n);
    for (std::size_t k = 0; k < rest.size(); ++k) {
      ASSERT_EQ(rest[k].imu.size(), taken[n + k].imu.size()) << n << " " << k;
      if (!rest[k].imu.empty()) {
        EXPECT_EQ(rest[k].imu.front().stamp, taken[n + k].imu.front().stamp);
      }
    }
  }
}

TEST(RawlogNavigation, ReadingsThatMakeNoSenseAreDropped) {
  auto blind = imuAt(0.02);
  blind->dataIsPresent[mrpt::obs::IMU_WX] = false;
  auto broken = imuAt(0.03);
  broken->set(mrpt::obs::IMU_X_ACC, std::nan(""));
  auto timeless = imuAt(0.04);
  timeless->timestamp = INVALID_TIMESTAMP;
  const auto scans = test::readAll(
      *sourceOf({scanAt(0), imuAt(0.01), blind, broken, timeless, imuAt(0.005), imuAt(0.05, "second"), imuAt(0.06)}));
  ASSERT_EQ(scans[0].imu.size(), 2U) << "in order of time, complete, finite, of the first label";
  EXPECT_NEAR(scans[0].imu[1].gyro_rad_s.z(), 0.06, 1e-12);
}

mrpt::obs::CObservationGPS::Ptr fixAt(double after_s, int quality, float hdop) {
  auto gps = mrpt::obs::CObservationGPS::Create();
  gps->timestamp = after(after_s);
  gps->sensorPose = CPose3D(-0.5, 0.1, 1.7, 0, 0, 0);
  mrpt::obs::gnss::Message_NMEA_GGA gga;
  gga.fields.latitude_degrees = 36.5, gga.fields.longitude_degrees = 127.25;
  gga.fields.altitude_meters = 60, gga.fields.geoidal_distance = 25;
  gga.fields.fix_quality = static_cast<std::uint8_t>(quality);
  gga.fields.thereis_HDOP = hdop > 0, gga.fields.HDOP = hdop;
  gps->setMsg(gga);
  return gps;
}

TEST(RawlogNavigation, SatelliteFixesComeWithACovarianceFromTheirDilution) {
  const auto scans =
      test::readAll(*sourceOf({scanAt(0), fixAt(0.05, 2, 2.0F), scanAt(1), fixAt(0.12, 0, 1), fixAt(0.15, 4, 0)}));
  ASSERT_EQ(scans[0].gnss.size(), 2U) << "up to the first after the next scan; no fix, no reading";
  const GnssFix& fix = scans[0].gnss[0];
  EXPECT_EQ(fix.latitude_deg, 36.5);
  EXPECT_EQ(fix.longitude_deg, 127.25);
  EXPECT_EQ(fix.height_m, 85) << "above the ellipsoid";
  EXPECT_NEAR(std::sqrt(fix.covariance_m2(0, 0)), 1.4, 1e-9);
  EXPECT_NEAR(std::sqrt(fix.covariance_m2(2, 2)), 2.8, 1e-9);
  EXPECT_NEAR(fix.antenna_in_base_m.z(), 1.7, 1e-12);
  EXPECT_NEAR(std::sqrt(scans[0].gnss[1].covariance_m2(1, 1)), 0.02, 1e-9) << "RTK";
  EXPECT_TRUE(scans[1].gnss.empty());
}

}  // namespace
}  // namespace scslam
