#include "scslam/sensor/rawlog_scans.h"

#include <mrpt/maps/CPointsMapXYZI.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "scslam/core/error.h"
#include "scslam/core/mrpt_pose.h"
#include "scslam/sensor/cloud_files.h"
#include "scslam/sensor/radar_observation.h"
#include "scslam/sensor/radar_sweep.h"
#include "scslam/sensor/rawlog_objects.h"

namespace scslam {

using mrpt::obs::CObservation2DRangeScan;
using mrpt::obs::CObservationPointCloud;
using mrpt::obs::CObservationRotatingScan;
using mrpt::obs::CObservationVelodyneScan;
using mrpt::obs::VelodyneCalibration;

namespace {

/// MRPT's calibration for a Velodyne of so many lasers (its HDL-64 one is broken in 2.5.8); null when it has none.
const VelodyneCalibration* builtInCalibration(std::size_t lasers) {
  if (lasers != 16 && lasers != 32) return nullptr;
  const auto& calibration = VelodyneCalibration::LoadDefaultCalibration(lasers == 16 ? "VLP16" : "HDL32");
  return calibration.laser_corrections.size() == lasers ? &calibration : nullptr;
}

/// Laser number to ring: 0 = lowest.
std::vector<std::uint16_t> ringOfLaser(const VelodyneCalibration& calibration) {
  const auto& lasers = calibration.laser_corrections;
  std::vector<std::size_t> by_elevation(lasers.size());
  std::iota(by_elevation.begin(), by_elevation.end(), std::size_t{0});
  std::stable_sort(by_elevation.begin(), by_elevation.end(), [&lasers](std::size_t a, std::size_t b) {
    return lasers[a].verticalCorrection < lasers[b].verticalCorrection;
  });
  std::vector<std::uint16_t> ring(lasers.size());
  for (std::size_t r = 0; r < ring.size(); ++r) ring[by_elevation[r]] = static_cast<std::uint16_t>(r);
  return ring;
}

bool isVelodyne(const CObservationRotatingScan& scan) {
  return scan.lidarModel.find("VLP") != std::string::npos || scan.lidarModel.find("HDL") != std::string::npos;
}

Cloud cloudFrom(const CObservation2DRangeScan& scan) {
  const std::size_t n = scan.getScanSize();
  const double step = n > 1 ? scan.aperture / static_cast<double>(n - 1) : 0.0;
  const double first = scan.rightToLeft ? -0.5 * scan.aperture : 0.5 * scan.aperture;
  Cloud cloud;
  for (std::size_t i = 0; i < n; ++i) {
    if (!scan.getScanRangeValidity(i)) continue;
    const double range = scan.getScanRange(i);
    const double angle = first + (scan.rightToLeft ? step : -step) * static_cast<double>(i);
    cloud.push(static_cast<float>(range * std::cos(angle)), static_cast<float>(range * std::sin(angle)), 0.F);
    if (scan.hasIntensity()) cloud.intensity.push_back(static_cast<float>(scan.getScanIntensity(i)));
  }
  cloud.ring.assign(cloud.size(), 0);
  return cloud;
}

Cloud cloudFrom(const mrpt::maps::CPointsMap& map) {
  Cloud cloud;
  const auto copy = [](const auto& from, std::vector<float>& to) { to.assign(from.begin(), from.end()); };
  copy(map.getPointsBufferRef_x(), cloud.x);
  copy(map.getPointsBufferRef_y(), cloud.y);
  copy(map.getPointsBufferRef_z(), cloud.z);
  if (const auto* xyzi = dynamic_cast<const mrpt::maps::CPointsMapXYZI*>(&map)) {
    cloud.intensity.resize(cloud.size());
    for (std::size_t i = 0; i < cloud.size(); ++i) cloud.intensity[i] = xyzi->getPointIntensity_fast(i);
  }
  return cloud;
}

/// The file of an externally stored cloud: as named, beside the rawlog, or in MRPT's "<rawlog>_Images" folder.
std::filesystem::path externalFile(const std::string& name, const std::filesystem::path& rawlog) {
  const auto folder = rawlog.parent_path();
  for (const auto& file :
       {std::filesystem::path(name), folder / name, folder / (rawlog.stem().string() + "_Images") / name})
    if (std::filesystem::is_regular_file(file)) return file;
  throw inputError("{}: the point cloud file {} that it refers to is not there", rawlog.string(), name);
}

Cloud cloudFrom(const CObservationPointCloud& observation, const std::filesystem::path& rawlog) {
  if (observation.pointcloud) return cloudFrom(*observation.pointcloud);
  const auto file = externalFile(observation.getExternalStorageFile(), rawlog);
  if (RawlogObjects::firstClassName(file).empty()) return readCloudFile(file);  // KITTI bin or text, by its extension
  const auto map = std::dynamic_pointer_cast<mrpt::maps::CPointsMap>(RawlogObjects(file).next());
  if (!map) throw inputError("{} holds no point cloud", file.string());
  return cloudFrom(*map);
}

/// Times of the points after `stamp` [s]. A LiDAR whose clock is another than the recorder's is taken relative to its
/// earliest point.
std::vector<float> timesAfter(Stamp stamp, const std::vector<Stamp>& times) {
  if (times.empty()) return {};
  const auto [earliest, latest] = std::minmax_element(times.begin(), times.end());
  const bool one_clock = std::abs(secondsBetween(stamp, *earliest)) < 1 && std::abs(secondsBetween(stamp, *latest)) < 1;
  const Stamp zero = one_clock ? stamp : *earliest;
  std::vector<float> dt(times.size());
  std::transform(times.begin(), times.end(), dt.begin(),
                 [zero](Stamp t) { return static_cast<float>(secondsBetween(zero, t)); });
  return dt;
}

/// Makes point_cloud from the packets. @return ring by laser number.
std::vector<std::uint16_t> unpack(CObservationVelodyneScan& scan) {
  if (scan.calibration.empty()) {
    constexpr std::uint8_t kHdl32 = 0x21;
    const auto* built_in = builtInCalibration(scan.scan_packets[0].velodyne_model_ID == kHdl32 ? 32 : 16);
    if (built_in != nullptr) scan.calibration = *built_in;
  }
  CObservationVelodyneScan::TGeneratePointCloudParameters params;
  params.generatePerPointTimestamp = true;
  params.minDistance = static_cast<float>(scan.minRange);
  try {
    scan.generatePointCloud(params);
  } catch (const std::exception& error) {
    const std::string text = error.what();
    throw inputError("the packets of a Velodyne scan make no sense: {}", text.substr(0, text.find('\n')));
  }
  return ringOfLaser(scan.calibration);
}

Cloud cloudFrom(CObservationVelodyneScan& scan) {
  std::vector<std::uint16_t> ring_of_laser;  // empty: laser_id is the ring
  if (scan.point_cloud.x.empty() && !scan.scan_packets.empty()) ring_of_laser = unpack(scan);
  auto& from = scan.point_cloud;
  const std::size_t n = from.x.size();
  const auto fits = [n](std::size_t size, bool optional) { return size == n || (optional && size == 0); };
  if (!fits(from.y.size(), false) || !fits(from.z.size(), false) || !fits(from.intensity.size(), true) ||
      !fits(from.timestamp.size(), true) || !fits(from.laser_id.size(), true))
    throw inputError("a Velodyne scan's lists of points differ in length");
  Cloud cloud;
  cloud.x = from.x, cloud.y = from.y, cloud.z = from.z;
  cloud.intensity.assign(from.intensity.begin(), from.intensity.end());
  cloud.dt = timesAfter(scan.timestamp, from.timestamp);
  cloud.ring.resize(from.laser_id.size());
  for (std::size_t i = 0; i < cloud.ring.size(); ++i) {
    const auto laser = static_cast<std::uint16_t>(from.laser_id[i]);
    cloud.ring[i] = laser < ring_of_laser.size() ? ring_of_laser[laser] : laser;
  }
  return cloud;
}

/// Direction of one row of a range image.
struct Row {
  double sin_elevation, cos_elevation, azimuth_offset, vertical_offset;
  std::uint16_t ring;
};

std::vector<Row> rowsOf(const CObservationRotatingScan& scan, const std::optional<SensorModel>& sensor) {
  std::vector<Row> rows;
  if (sensor && sensor->elevation_deg.size() == scan.rowCount) {
    for (std::size_t r = 0; r < scan.rowCount; ++r) {
      const double elevation = sensor->elevation_deg[r] * M_PI / 180;
      rows.push_back({std::sin(elevation), std::cos(elevation), 0, 0, static_cast<std::uint16_t>(r)});
    }
  } else if (const auto* calibration = isVelodyne(scan) ? builtInCalibration(scan.rowCount) : nullptr) {
    const auto ring = ringOfLaser(*calibration);
    for (std::size_t r = 0; r < scan.rowCount; ++r) {
      const auto& laser = calibration->laser_corrections[r];
      rows.push_back({laser.sinVertCorrection, laser.cosVertCorrection, laser.azimuthCorrection * M_PI / 180,
                      laser.verticalOffsetCorrection, ring[r]});
    }
  }
  return rows;
}

/// Columns the sweep is spread over. MRPT 2.5.8 converts Velodyne packets into an image with a column for every return
/// of every laser, of which only the first of each `rowCount` is a firing and the rest stay empty at the end.
int firings(const CObservationRotatingScan& scan) {
  const int columns = scan.columnCount, rows = scan.rowCount;
  if (!isVelodyne(scan) || rows < 2 || columns % rows != 0) return columns;
  for (int c = columns / rows; c < columns; ++c)
    for (int r = 0; r < rows; ++r)
      if (scan.rangeImage(r, c) != 0) return columns;
  return columns / rows;
}

Cloud cloudFrom(const CObservationRotatingScan& scan, const std::optional<SensorModel>& sensor) {
  const auto n_rows = static_cast<int>(scan.rowCount), n_columns = static_cast<int>(scan.columnCount);
  const auto rows = rowsOf(scan, sensor);
  const bool intensity = scan.intensityImage.size() != 0;
  if (scan.rangeImage.rows() != n_rows || scan.rangeImage.cols() != n_columns || !(scan.rangeResolution > 0) ||
      (intensity && (scan.intensityImage.rows() != n_rows || scan.intensityImage.cols() != n_columns)))
    throw inputError("a rotating scan's images differ in size");
  Cloud cloud;
  const double sign = isVelodyne(scan) ? -1 : 1;  // Velodyne's azimuth grows clockwise; MRPT stores it as it is
  const int n_firings = firings(scan);
  for (int c = 0; c < n_firings; ++c) {
    const double part = static_cast<double>(c) / n_firings;
    for (int r = 0; r < n_rows; ++r) {
      const std::uint16_t range_units = scan.rangeImage(r, c);
      if (range_units == 0) continue;
      const Row& row = rows[static_cast<std::size_t>(r)];
      const double range = range_units * scan.rangeResolution;
      const double azimuth = sign * (scan.startAzimuth + scan.azimuthSpan * part - row.azimuth_offset);
      const double flat = range * row.cos_elevation;
      cloud.push(static_cast<float>(flat * std::cos(azimuth)), static_cast<float>(flat * std::sin(azimuth)),
                 static_cast<float>(range * row.sin_elevation + row.vertical_offset));
      if (intensity) cloud.intensity.push_back(scan.intensityImage(r, c));
      cloud.dt.push_back(static_cast<float>(scan.sweepDuration * part));
      cloud.ring.push_back(row.ring);
    }
  }
  return cloud;
}

}  // namespace

bool isRadarScan(const mrpt::obs::CObservation& observation) {
  return dynamic_cast<const CObservationRadar*>(&observation) != nullptr;
}

bool isPlanarScan(const mrpt::obs::CObservation& observation) {
  return dynamic_cast<const CObservation2DRangeScan*>(&observation) != nullptr || isRadarScan(observation);
}

bool isScan(const mrpt::obs::CObservation& observation, const std::optional<SensorModel>& sensor) {
  if (const auto* scan = dynamic_cast<const CObservation2DRangeScan*>(&observation)) return scan->getScanSize() != 0;
  if (const auto* radar = dynamic_cast<const CObservationRadar*>(&observation)) return radar->scan.azimuths != 0;
  if (const auto* scan = dynamic_cast<const CObservationVelodyneScan*>(&observation))
    return !scan->point_cloud.x.empty() || !scan->scan_packets.empty();
  if (const auto* scan = dynamic_cast<const CObservationPointCloud*>(&observation))
    return scan->pointcloud != nullptr || scan->isExternallyStored();
  if (const auto* scan = dynamic_cast<const CObservationRotatingScan*>(&observation))
    return scan->rowCount != 0 && rowsOf(*scan, sensor).size() == scan->rowCount;
  return false;
}

Scan scanFrom(mrpt::obs::CObservation& observation, const std::optional<SensorModel>& sensor,
              const std::filesystem::path& rawlog) {
  Scan scan;
  if (const auto* radar = dynamic_cast<const CObservationRadar*>(&observation)) {
    RadarScan sweep = radar->scan;
    if (sensor) applyTable(sensor->radar, sweep);
    scan = scanOfSweep(std::move(sweep));
  }
  if (const auto* planar = dynamic_cast<const CObservation2DRangeScan*>(&observation)) {
    scan.cloud = cloudFrom(*planar);
    scan.planar = true;
  } else if (auto* velodyne = dynamic_cast<CObservationVelodyneScan*>(&observation)) {
    scan.cloud = cloudFrom(*velodyne);
  } else if (const auto* points = dynamic_cast<const CObservationPointCloud*>(&observation)) {
    scan.cloud = cloudFrom(*points, rawlog);
  } else if (const auto* image = dynamic_cast<const CObservationRotatingScan*>(&observation)) {
    scan.cloud = cloudFrom(*image, sensor);
  }
  scan.stamp = observation.timestamp;
  scan.label = observation.sensorLabel;
  mrpt::poses::CPose3D pose;
  observation.getSensorPose(pose);
  scan.T_base_sensor = sensor ? sensor->T_base_sensor() : fromMrpt(pose);
  if (sensor) completeFromTable(scan.cloud, *sensor);
  return scan;
}

}  // namespace scslam
