// The shipped sensor tables (configs/sensors/*.yaml), and tables of the user's own.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "scslam/sensor/sensor_model.h"

namespace scslam {

/// @param name_or_file "vlp16", or the path of a YAML file.
/// @throw usageError for an unknown name (with the known ones) or a file that is wrong (with line and column).
SensorModel loadSensorModel(const std::string& name_or_file);

/// Names of the shipped tables, sorted.
std::vector<std::string> sensorModelNames();

}  // namespace scslam
