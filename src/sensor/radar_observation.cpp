#include "scslam/sensor/radar_observation.h"

#include <mrpt/core/initializer.h>
#include <mrpt/rtti/CObject.h>
#include <mrpt/serialization/CArchive.h>

#include <bit>
#include <cmath>
#include <ostream>

#include "scslam/core/error.h"
#include "scslam/core/mrpt_pose.h"
#include "scslam/sensor/guarded_archive.h"

IMPLEMENTS_SERIALIZABLE(CObservationRadar, CObservation, scslam)
MRPT_INITIALIZER(registerRadarObservation) { mrpt::rtti::registerClass(CLASS_ID_NAMESPACE(CObservationRadar, scslam)); }

namespace scslam {

static_assert(std::endian::native == std::endian::little, "arrays are written as they lie in memory");

namespace {

constexpr std::size_t kMaxAzimuths = 1 << 14, kMaxBins = 1 << 16, kMaxLabel = 4096;  // real ones: 400 x 3768
constexpr double kMaxResolution = 100, kMaxOffset = 1000;                            // [m]
constexpr double kMaxBeta = 10;                                                      // [s]
constexpr std::size_t kBytesPerRow = 8 + 8 + 1;                                      // stamp, angle, validity

/// What is wrong with a scan, nullptr if nothing.
const char* faultOf(const RadarScan& scan) {
  if (!scan.consistent()) return "its vectors do not fit its size";
  if (scan.azimuths > kMaxAzimuths || scan.bins > kMaxBins) return "it has an absurd size";
  if (!(scan.range_resolution_m > 0 && scan.range_resolution_m <= kMaxResolution)) return "it has an absurd resolution";
  if (!(std::abs(scan.range_offset_m) <= kMaxOffset)) return "it has an absurd range offset";
  if (!(std::abs(scan.doppler_beta_s) <= kMaxBeta)) return "it has an absurd Doppler factor";
  if (!isRigid(scan.T_base_sensor)) return "the pose of its sensor is no rigid motion";
  for (const double angle : scan.angles)
    if (!std::isfinite(angle)) return "it has an angle that is not a number";
  return nullptr;
}

[[noreturn]] void refuse(const std::string& why) { THROW_EXCEPTION("a radar scan is unreadable: " + why); }

/// Exactly the elements that were asked for; MRPT accepts fewer.
template <class T>
void readArray(mrpt::serialization::CArchive& in, T* to, std::size_t count) {
  if (in.ReadBuffer(to, count * sizeof(T)) != count * sizeof(T)) refuse("the file ends there");
}

template <class T>
void writeArray(mrpt::serialization::CArchive& out, const T* from, std::size_t count) {
  out.WriteBuffer(from, count * sizeof(T));
}

/// As MRPT writes a string, but it would take memory for whatever length is stated.
std::string readLabel(mrpt::serialization::CArchive& in) {
  const auto length = in.ReadAs<std::uint32_t>();
  if (length > kMaxLabel) refuse(fmt::format("a label of {} bytes is absurd", length));
  std::string label(length, '\0');
  if (length != 0) readArray(in, label.data(), length);
  return label;
}

/// Grows with the bytes that are there, whatever size was stated.
void readRows(mrpt::serialization::CArchive& in, RadarScan& scan) {
  for (std::size_t i = 0; i < scan.azimuths; ++i) {
    std::int64_t ticks = 0;
    double angle = 0;
    std::uint8_t valid = 0;
    readArray(in, &ticks, 1), readArray(in, &angle, 1), readArray(in, &valid, 1);
    scan.stamps.emplace_back(Stamp::duration(ticks));
    scan.angles.push_back(angle);
    scan.valid.push_back(valid);
    scan.power.resize(scan.power.size() + scan.bins);
    readArray(in, scan.row(i).data(), scan.bins);
  }
}

}  // namespace

CObservationRadar::CObservationRadar(RadarScan radar_scan) : scan(std::move(radar_scan)) {
  if (const char* fault = faultOf(scan)) throw inputError("a radar scan cannot be kept: {}", fault);
  timestamp = scan.stamps.empty() ? Stamp{} : scan.stamps.front();
  sensorLabel = scan.label;
}

void CObservationRadar::getSensorPose(mrpt::poses::CPose3D& T_base_sensor) const {
  T_base_sensor = toMrpt(scan.T_base_sensor);
}

void CObservationRadar::setSensorPose(const mrpt::poses::CPose3D& T_base_sensor) {
  scan.T_base_sensor = fromMrpt(T_base_sensor);
}

void CObservationRadar::getDescriptionAsText(std::ostream& out) const {
  CObservation::getDescriptionAsText(out);
  out << fmt::format("Spinning radar: {} azimuths x {} bins of {} m, range offset {} m, Doppler {} s\n", scan.azimuths,
                     scan.bins, scan.range_resolution_m, scan.range_offset_m, scan.doppler_beta_s);
}

std::uint8_t CObservationRadar::serializeGetVersion() const { return 1; }

void CObservationRadar::serializeTo(mrpt::serialization::CArchive& out) const {
  if (const char* fault = faultOf(scan)) refuse(fault);
  if (sensorLabel.size() > kMaxLabel) refuse("its label is too long");
  out << timestamp << sensorLabel;
  const Eigen::Matrix<double, 3, 4, Eigen::RowMajor> T = scan.T_base_sensor.matrix().topRows<3>();
  writeArray(out, T.data(), 12);
  out << scan.range_resolution_m << scan.range_offset_m << scan.doppler_beta_s;
  out << static_cast<std::uint32_t>(scan.azimuths) << static_cast<std::uint32_t>(scan.bins);
  for (std::size_t i = 0; i < scan.azimuths; ++i) {
    const std::int64_t ticks = scan.stamps[i].time_since_epoch().count();
    writeArray(out, &ticks, 1), writeArray(out, &scan.angles[i], 1), writeArray(out, &scan.valid[i], 1);
    writeArray(out, scan.row(i).data(), scan.bins);
  }
}

void CObservationRadar::serializeFrom(mrpt::serialization::CArchive& in, std::uint8_t version) {
  if (version > 1) refuse(fmt::format("version {} is newer than this program", version));
  in >> timestamp;
  sensorLabel = readLabel(in);
  RadarScan read;
  Eigen::Matrix<double, 3, 4, Eigen::RowMajor> T;
  readArray(in, T.data(), 12);
  read.T_base_sensor.matrix().topRows<3>() = T;
  in >> read.range_resolution_m >> read.range_offset_m;
  if (version >= 1) in >> read.doppler_beta_s;
  read.azimuths = in.ReadAs<std::uint32_t>(), read.bins = in.ReadAs<std::uint32_t>();
  if (read.azimuths > kMaxAzimuths || read.bins > kMaxBins)
    refuse(fmt::format("{} x {} is absurd", read.azimuths, read.bins));
  auto* const guarded = dynamic_cast<GuardedArchive*>(&in);
  if (guarded != nullptr && read.azimuths * (read.bins + kBytesPerRow) > guarded->bytesLeft())
    refuse(fmt::format("{} x {} is more than the rest of the file can hold", read.azimuths, read.bins));
  readRows(in, read);
  read.label = sensorLabel;
  if (const char* fault = faultOf(read)) refuse(fault);
  scan = std::move(read);
}

}  // namespace scslam
