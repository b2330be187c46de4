// The polar PNG of Oxford Radar RobotCar, Boreas and MulRan's polar_oxford_form: 8-bit grey, one row per azimuth.
// Bytes of a row: 0-7 stamp [us since 1970; ns in MulRan's] and 8-9 encoder (0 … 5599), both little-endian, 10
// validity, then the power of each range bin.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "scslam/sensor/radar_scan.h"

namespace scslam {

constexpr int kNavtechEncoderCounts = 5600;

/// What the file does not say.
struct OxfordRadarFormat {
  double range_resolution_m = 0.0438;  ///< CTS350-X; CIR204-H has 0.0596
  double range_offset_m = 0;
  bool validity = true;  ///< byte 10 says whether the row was measured (Boreas leaves it unused)
  std::string label = "radar";
  Pose T_base_sensor = Pose::Identity();
};

/// @param name of the file, for messages.
/// @throw inputError for anything but such a PNG: damaged, other pixels, encoder beyond 5599, stamps that go back.
RadarScan decodeOxfordRadar(std::string_view png, const std::string& name, const OxfordRadarFormat& format = {});
RadarScan readOxfordRadar(const std::filesystem::path& file, const OxfordRadarFormat& format = {});

/// The bytes of the PNG file; the same scan gives the same bytes. Stamps are rounded down to microseconds, angles to
/// the nearest count. @throw inputError for a scan without rows or bins, or with stamps before 1970.
std::string encodeOxfordRadar(const RadarScan& scan);

}  // namespace scslam
