#include "scslam/sensor/sensor_tables.h"

#include "scslam/core/embedded_configs.h"
#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/suggest.h"

namespace scslam {
namespace {

const std::string kFolder = "sensors/";

void check(const SensorModel& sensor, const std::string& source) {
  const auto n = sensor.elevation_deg.size();
  if (n != 0 && n != static_cast<std::size_t>(sensor.rings))
    throw usageError("{}: elevation_deg has {} entries for {} rings", source, n, sensor.rings);
  for (std::size_t i = 1; i < n; ++i)
    if (!(sensor.elevation_deg[i] > sensor.elevation_deg[i - 1]))
      throw usageError("{}: elevation_deg must rise, entry {} does not", source, i);
  if (sensor.translation_m.size() != 3 || sensor.rpy_deg.size() != 3)
    throw usageError("{}: translation_m and rpy_deg have three entries each", source);
  if (sensor.min_range_m >= sensor.max_range_m) throw usageError("{}: min_range_m is not below max_range_m", source);
}

}  // namespace

SensorModel loadSensorModel(const std::string& name_or_file) {
  SensorModel sensor;
  std::string source = kFolder + name_or_file;
  if (const auto it = embeddedConfigs().find(source); it != embeddedConfigs().end()) {
    loadYaml(sensor, it->second, source);
  } else if (std::filesystem::is_regular_file(name_or_file)) {
    source = name_or_file;
    loadYaml(sensor, readFile(name_or_file, std::size_t{1} << 20), source);
  } else {
    throw usageError("no sensor table (nor file) is called '{}'{}", name_or_file,
                     didYouMean(name_or_file, sensorModelNames()));
  }
  check(sensor, source);
  return sensor;
}

std::vector<std::string> sensorModelNames() {
  std::vector<std::string> names;
  for (const auto& [name, text] : embeddedConfigs())
    if (name.starts_with(kFolder)) names.push_back(name.substr(kFolder.size()));
  return names;
}

}  // namespace scslam
