// Simulated observations as MRPT observations, and the rawlog they go into.
#pragma once
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/obs/CObservation.h>

#include <filesystem>
#include <string>

#include "scslam/core/stamp.h"
#include "scslam/sensor/sensor_model.h"
#include "sim/lidar.h"

namespace scslam::sim {

/// A rawlog of observations. It appears under its name when finish() was called; until then as NAME.part.
class RawlogWriter {
 public:
  /// @param compression 0 … 9, as gzip. @throw Error(kInput) when the file cannot be made.
  RawlogWriter(const std::filesystem::path& file, int compression);
  ~RawlogWriter();
  /// Each is one entry of the rawlog. @throw Error(kInput) when the disk is full.
  void add(const mrpt::obs::CObservation& observation);
  void finish();

 private:
  std::filesystem::path file_, part_;
  mrpt::io::CFileGZOutputStream stream_;
  bool finished_ = false;
};

/// A sweep as a CObservationVelodyneScan (the one class of MRPT that keeps time, ring and intensity of each point;
/// intensity there has 8 bits), or, of a sensor with one ring, as a CObservation2DRangeScan.
mrpt::obs::CObservation::Ptr asObservation(const LidarScan& scan, const Lidar& lidar, Stamp stamp,
                                           const std::string& label);

/// A text entry, how a simulated log says what it is.
mrpt::obs::CObservation::Ptr asComment(const std::string& text, Stamp stamp);

/// SHA-256 of a file, in hexadecimal.
std::string sha256Of(const std::filesystem::path& file);

}  // namespace scslam::sim
