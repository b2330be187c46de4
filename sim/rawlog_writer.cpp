#include "sim/rawlog_writer.h"

#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <mrpt/serialization/CArchive.h>
#include <openssl/evp.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>

#include "scslam/core/error.h"
#include "scslam/core/mrpt_pose.h"

namespace scslam::sim {

namespace fs = std::filesystem;

RawlogWriter::RawlogWriter(const fs::path& file, int compression) : file_(file), part_(file.string() + ".part") {
  if (!stream_.open(part_.string(), compression)) throw inputError("cannot write {}", part_.string());
}

RawlogWriter::~RawlogWriter() {
  if (finished_) return;
  stream_.close();
  std::error_code ignored;
  fs::remove(part_, ignored);
}

void RawlogWriter::add(const mrpt::obs::CObservation& observation) {
  try {
    mrpt::serialization::archiveFrom(stream_) << observation;
  } catch (const std::exception&) {
    throw inputError("cannot write {}: is the disk full?", part_.string());
  }
}

void RawlogWriter::finish() {
  stream_.close();
  std::error_code error;
  fs::rename(part_, file_, error);
  if (error) throw inputError("cannot write {}: {}", file_.string(), error.message());
  finished_ = true;
}

namespace {

mrpt::obs::CObservation::Ptr asVelodyne(const LidarScan& scan, const SensorModel& sensor, Stamp stamp) {
  auto observation = std::make_shared<mrpt::obs::CObservationVelodyneScan>();
  observation->timestamp = stamp;
  observation->minRange = sensor.min_range_m, observation->maxRange = sensor.max_range_m;
  observation->sensorPose = toMrpt(sensor.T_base_sensor());
  auto& points = observation->point_cloud;
  const std::size_t n = scan.cloud.size();
  points.x.assign(scan.cloud.x.begin(), scan.cloud.x.end());
  points.y.assign(scan.cloud.y.begin(), scan.cloud.y.end());
  points.z.assign(scan.cloud.z.begin(), scan.cloud.z.end());
  points.intensity.resize(n), points.timestamp.resize(n), points.laser_id.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    points.intensity[i] = static_cast<std::uint8_t>(std::clamp(scan.cloud.intensity[i], 0.F, 255.F));
    points.timestamp[i] = stamp + (stampFromSeconds(static_cast<double>(scan.cloud.dt[i])) - stampFromSeconds(0));
    points.laser_id[i] = static_cast<std::int16_t>(scan.cloud.ring[i]);
  }
  return observation;
}

/// The columns that are not blind must follow each other: they are the aperture.
mrpt::obs::CObservation::Ptr asRangeScan(const LidarScan& scan, const Lidar& lidar, Stamp stamp) {
  const BeamGrid& grid = lidar.grid();
  const SensorModel& sensor = lidar.sensor();
  std::vector<double> azimuths;
  for (int c = 0; c < grid.columns(); ++c) {
    const Eigen::Vector3f d = grid.direction(c, 0);
    if (grid.isActive(c, 0)) azimuths.push_back(static_cast<double>(std::atan2(d.y(), d.x())));
  }
  std::sort(azimuths.begin(), azimuths.end());
  auto observation = std::make_shared<mrpt::obs::CObservation2DRangeScan>();
  observation->timestamp = stamp;
  observation->maxRange = static_cast<float>(sensor.max_range_m);
  observation->sensorPose = toMrpt(sensor.T_base_sensor());
  observation->rightToLeft = true;
  observation->aperture = static_cast<float>(azimuths.back() - azimuths.front());
  observation->resizeScanAndAssign(azimuths.size(), static_cast<float>(sensor.max_range_m), false);
  const double step = (azimuths.back() - azimuths.front()) / static_cast<double>(azimuths.size() - 1);
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    const double azimuth = std::atan2(static_cast<double>(scan.cloud.y[i]), static_cast<double>(scan.cloud.x[i]));
    const auto k = static_cast<std::size_t>(
        std::clamp(std::lround((azimuth - azimuths.front()) / step), 0L, static_cast<long>(azimuths.size()) - 1));
    observation->setScanRange(k, scan.cloud.point(i).norm());
    observation->setScanRangeValidity(k, true);
  }
  return observation;
}

}  // namespace

mrpt::obs::CObservation::Ptr asObservation(const LidarScan& scan, const Lidar& lidar, Stamp stamp,
                                           const std::string& label) {
  auto observation =
      lidar.grid().rings() == 1 ? asRangeScan(scan, lidar, stamp) : asVelodyne(scan, lidar.sensor(), stamp);
  observation->sensorLabel = label;
  return observation;
}

mrpt::obs::CObservation::Ptr asComment(const std::string& text, Stamp stamp) {
  auto comment = std::make_shared<mrpt::obs::CObservationComment>();
  comment->timestamp = stamp, comment->sensorLabel = "scslam_sim", comment->text = text;
  return comment;
}

std::string sha256Of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw inputError("cannot read {}", file.string());
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(), &EVP_MD_CTX_free);
  EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr);
  std::vector<char> block(1 << 20);
  while (in.read(block.data(), std::ssize(block)), in.gcount() > 0)
    EVP_DigestUpdate(context.get(), block.data(), static_cast<std::size_t>(in.gcount()));
  std::array<unsigned char, 32> digest{};
  EVP_DigestFinal_ex(context.get(), digest.data(), nullptr);
  std::string text;
  for (const unsigned char byte : digest) text += fmt::format("{:02x}", byte);
  return text;
}

}  // namespace scslam::sim
