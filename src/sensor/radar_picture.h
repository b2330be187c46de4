// Radar images that carry no stamps and angles of their own: MulRan's polar, RADIATE's Navtech_Polar.
#pragma once
#include <filesystem>

#include "scslam/sensor/radar_scan.h"
#include "scslam/sensor/sensor_model.h"

namespace scslam {

/// Stamps of all azimuths, evenly over table.sweep_s, from the one stamp an image has (table.radar.stamp says whose).
void stampRows(RadarScan& sweep, Stamp stamp, const SensorModel& table);

/// An 8-bit grey PNG with azimuths as columns (range downwards) or as rows: table.columns tells which side they are;
/// angles from table.radar.first_azimuth_deg on, evenly, clockwise or not as the table says; stamps by stampRows.
/// @throw inputError for what is no such picture.
RadarScan readRadarPicture(const std::filesystem::path& file, Stamp stamp, const SensorModel& table);

}  // namespace scslam
