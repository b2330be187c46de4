#include "scslam/sensor/rawlog_navigation.h"

#include <fmt/format.h>
#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationIMU.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "scslam/core/mrpt_pose.h"

namespace scslam {

using mrpt::obs::CObservationGPS;
using mrpt::obs::CObservationIMU;

namespace {

/// Rates and accelerations; nullopt when the IMU has not all six. MRPT numbers the rates z, y, x.
std::optional<ImuSample> sampleFrom(const CObservationIMU& imu) {
  using namespace mrpt::obs;
  constexpr TIMUDataIndex kRates[3] = {IMU_WX, IMU_WY, IMU_WZ}, kForces[3] = {IMU_X_ACC, IMU_Y_ACC, IMU_Z_ACC};
  ImuSample sample;
  sample.stamp = imu.timestamp;
  for (int i = 0; i < 3; ++i) {
    if (!imu.has(kRates[i]) || !imu.has(kForces[i])) return std::nullopt;
    sample.gyro_rad_s[i] = imu.get(kRates[i]);
    sample.accel_m_s2[i] = imu.get(kForces[i]);
  }
  if (!sample.gyro_rad_s.allFinite() || !sample.accel_m_s2.allFinite()) return std::nullopt;
  return sample;
}

/// One-sigma range error [m] by the quality field of GGA: what HDOP multiplies.
double rangeError(int fix_quality) {
  switch (fix_quality) {
    case 2:
      return 0.7;  // differential
    case 4:
      return 0.02;  // RTK, integers fixed
    case 5:
      return 0.25;  // RTK, integers floating
    default:
      return 3.0;
  }
}

/// nullopt without a fix. GGA states no covariance: HDOP times the range error of its quality; vertical twice that.
std::optional<GnssFix> fixFrom(const CObservationGPS& gps) {
  using Gga = mrpt::obs::gnss::Message_NMEA_GGA;
  if (!gps.hasMsgClass<Gga>()) return std::nullopt;
  const auto& gga = gps.getMsgByClass<Gga>().fields;
  if (gga.fix_quality == 0) return std::nullopt;
  GnssFix fix;
  fix.stamp = gps.timestamp;
  fix.latitude_deg = gga.latitude_degrees;
  fix.longitude_deg = gga.longitude_degrees;
  fix.height_m = gga.altitude_meters + gga.geoidal_distance;
  const double hdop = gga.thereis_HDOP && gga.HDOP > 0 ? std::clamp<double>(gga.HDOP, 0.3, 100) : 1.0;
  const double sigma_m = hdop * rangeError(gga.fix_quality);
  fix.covariance_m2 = Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m, 4 * sigma_m * sigma_m).asDiagonal();
  fix.antenna_in_base_m = fromMrpt(gps.sensorPose).translation();
  const bool on_earth = std::abs(fix.latitude_deg) <= 90 && std::abs(fix.longitude_deg) <= 180;  // false for NaN
  return on_earth && std::isfinite(fix.height_m) && fix.antenna_in_base_m.allFinite() ? std::optional(fix)
                                                                                      : std::nullopt;
}

/// Is this the sensor whose readings are taken? The first one becomes it. An empty label counts as "unnamed".
bool chosen(const std::string& label, std::string& taken) {
  const std::string name = label.empty() ? "unnamed" : label;
  if (taken.empty()) taken = name;
  return taken == name;
}

template <class Reading>
void append(const Reading& reading, std::deque<Reading>& readings, Stamp& last, std::size_t most) {
  if (reading.stamp <= last) return;
  last = reading.stamp;
  readings.push_back(reading);
  if (readings.size() > most) readings.pop_front();
}

template <class Reading>
void moveUpTo(const Stamp* end, std::deque<Reading>& from, Stamp& handed, std::vector<Reading>& to) {
  while (!from.empty() && (end == nullptr || handed < *end)) {
    handed = from.front().stamp;
    to.push_back(from.front());
    from.pop_front();
  }
}

}  // namespace

void RawlogNavigation::take(const mrpt::obs::CObservation& observation) {
  if (observation.timestamp == INVALID_TIMESTAMP) return;
  if (const auto* imu = dynamic_cast<const CObservationIMU*>(&observation)) {
    const auto sample = sampleFrom(*imu);
    if (!sample || !chosen(imu->sensorLabel, imu_label_)) return;
    T_base_imu_ = fromMrpt(imu->sensorPose);
    append(*sample, imu_, last_imu_, kMost);
  } else if (const auto* gps = dynamic_cast<const CObservationGPS*>(&observation)) {
    const auto fix = fixFrom(*gps);
    if (fix && chosen(gps->sensorLabel, gnss_label_)) append(*fix, gnss_, last_gnss_, kMost);
  }
}

bool RawlogNavigation::covers(Stamp next_scan) const {
  return (!hasImu() || last_imu_ >= next_scan) && (!hasGnss() || last_gnss_ >= next_scan);
}

void RawlogNavigation::handTo(Scan& scan, const Stamp* next_scan) {
  scan.T_base_imu = T_base_imu_;
  moveUpTo(next_scan, imu_, handed_imu_, scan.imu);
  moveUpTo(next_scan, gnss_, handed_gnss_, scan.gnss);
}

std::string RawlogNavigation::description() const {
  std::string text = hasImu() ? fmt::format("imu '{}'", imu_label_) : "";
  if (hasGnss()) text += fmt::format("{}gnss '{}'", text.empty() ? "" : ", ", gnss_label_);
  return text;
}

}  // namespace scslam
