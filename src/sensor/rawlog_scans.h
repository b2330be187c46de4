// From MRPT's observation classes to our Scan.
#pragma once
#include <mrpt/obs/CObservation.h>

#include <filesystem>
#include <optional>

#include "scslam/sensor/scan.h"
#include "scslam/sensor/sensor_model.h"

namespace scslam {

/// Is this an observation that scanFrom() makes a scan of: CObservation2DRangeScan, CObservationPointCloud,
/// CObservationVelodyneScan with points or packets, CObservationRotatingScan of a sensor whose elevations are known,
/// CObservationRadar?
bool isScan(const mrpt::obs::CObservation& observation, const std::optional<SensorModel>& sensor);
bool isPlanarScan(const mrpt::obs::CObservation& observation);
bool isRadarScan(const mrpt::obs::CObservation& observation);

/// Cloud (sensor frame), stamp, T_base_sensor, planar and label.
/// - 2DRangeScan: the valid rays, in scanning order; ring 0; no per-ray time, the class has none.
/// - VelodyneScan: point_cloud as it stands when filled (laser_id is then the ring); otherwise made from the packets
///   with the calibration they carry (MRPT's own for VLP-16 and HDL-32), ring by elevation.
/// - RotatingScan: the range image with the sensor table's elevations or, for a VLP-16 or HDL-32, MRPT's calibration.
/// - PointCloud: any CPointsMap, intensity of CPointsMapXYZI; also stored in a file beside `rawlog`.
/// - Radar: the sweep (Scan::radar), mended; no points yet. A table's resolution and offset replace the recorded ones.
/// @param sensor the user's table; its extrinsic replaces the recorded one.
/// @throw inputError when the observation contradicts itself.
Scan scanFrom(mrpt::obs::CObservation& observation, const std::optional<SensorModel>& sensor,
              const std::filesystem::path& rawlog);

}  // namespace scslam
