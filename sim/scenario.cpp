#include "sim/scenario.h"

#include <filesystem>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/suggest.h"
#include "sim/embedded.h"

namespace scslam::sim {

void WorldParams::describe(ParamVisitor& v) {
  kind.describe(v, "kind", "which world");
  v.field("seed", seed, "seed of the world alone; 0 = the scenario's");
}

void LidarParams::describe(ParamVisitor& v) {
  v.field("on", on, "is there a LiDAR");
  v.field("sensor", sensor, "sensor table: a shipped name or a YAML file");
  v.field("translation_m", translation_m, "position of the sensor in the base frame: x y z [m]");
  v.field("rpy_deg", rpy_deg, "roll, pitch, yaw of the sensor in the base frame [deg]");
  v.group("effects", effects, "what the sensor adds to the truth");
}

void RadarParams::describe(ParamVisitor& v) {
  v.field("on", on, "is there a radar");
  v.field("sensor", sensor, "its table: a shipped name (cts350-x, cir204-h) or a YAML file");
  v.field("translation_m", translation_m, "position of the sensor in the base frame: x y z [m]");
  v.field("rpy_deg", rpy_deg, "roll, pitch, yaw of the sensor in the base frame [deg]");
  v.field("png", png, "write OUT.radar/<stamp in us>.png too, as the Oxford Radar RobotCar data set has them");
}

RadarModel RadarParams::model() const {
  RadarModel model;
  if (std::filesystem::is_regular_file(sensor)) {
    loadYaml(model, readFile(sensor, 1 << 20), sensor);
  } else {
    const auto found = embeddedFiles().find("radars/" + sensor);
    if (found == embeddedFiles().end()) throw usageError("there is no radar table '{}' (and no such file)", sensor);
    loadYaml(model, found->second, sensor);
  }
  model.translation_m = translation_m, model.rpy_deg = rpy_deg;
  return model;
}

bool FaultParams::off(double time_s) const {
  for (std::size_t k = 0; k + 1 < off_s.size(); k += 2)
    if (time_s >= off_s[k] && time_s < off_s[k + 1]) return true;
  return false;
}

void FaultParams::describe(ParamVisitor& v) {
  v.field("lost_scans", lost_scans, "share of the scans that are missing", 0, 0.95);
  v.field("time_offset_s", time_offset_s, "added to the stamps of the scans [s]", -10, 10);
  v.field("lost_rings", lost_rings, "share of the rings that are dead", 0, 1);
  v.field("dirty_deg", dirty_deg, "azimuths behind dirt: from, to, ... counter-clockwise [deg]");
  v.field("dirty_loss", dirty_loss, "share of the points lost there", 0, 1);
  v.field("off_s", off_s, "no sensor measures, and the robot is carried on: from, to, ... after the start [s]");
}

void TruthParams::describe(ParamVisitor& v) {
  v.field("labels", labels, "write OUT.labels/NNNNNN.label: class and instance of each point (SemanticKITTI)");
  v.field("firings", firings, "write OUT.firings.tum: the pose of the base at each firing of the sensor");
  v.field("loops", loops, "write OUT.loops.csv: pairs of places within 3 and 10 m, with heading, offset and overlap");
  v.field("aliases", aliases, "write OUT.aliases.csv: pairs of places that look alike and are not the same");
  v.field("pictures", pictures, "write OUT.world.png, OUT.oblique.png and OUT.scan.png");
  v.field("place_every_m", place_every_m, "distance travelled between the places that are compared [m]", 0.1, 1000);
  v.field("min_travel_m", min_travel_m, "what lies so near along the way is no revisit [m]", 0, 1e6);
}

void ExpectParams::describe(ParamVisitor& v) {
  v.field("slam", slam, "is the scenario for SLAM");
  v.field("config", config, "configuration that SLAM runs with; empty: its default");
  v.field("odometry", odometry, "front-end that SLAM runs with; empty: the configuration's");
  v.field("ate_max_m", ate_max_m, "greatest absolute trajectory error, rms [m]; negative: not asked");
  v.field("odometry_ate_max_m", odometry_ate_max_m, "the same of odometry alone [m]");
  v.field("false_loops_max", false_loops_max, "most loops accepted that are false");
  v.field("loops_min", loops_min, "fewest loops accepted that are true");
  v.field("recall_min", recall_min, "least share of revisits closed");
  v.field("z_rmse_max_m", z_rmse_max_m, "greatest rms error of the height [m]");
  v.field("nees_max", nees_max, "greatest mean of the steps' normalised squared errors; honest: 6, planar 3");
  v.field("wished_ate_m", wished_ate_m, "what a better program would reach [m]");
  v.field("wished_recall", wished_recall, "... and this recall");
}

void Scenario::describe(ParamVisitor& v) {
  v.field("name", name, "short name");
  v.field("summary", summary, "what it is about, one line");
  v.field("seed", seed, "of everything random", 1);
  v.group("world", world, "where it happens");
  v.group("drive", drive, "how the robot moves");
  v.group("lidar", lidar, "the LiDAR");
  v.group("radar", radar, "the radar");
  v.group("imu", imu, "the IMU");
  v.group("wheels", wheels, "wheel odometry");
  v.group("gnss", gnss, "the GNSS receiver");
  v.group("weather", weather, "rain and fog");
  v.group("faults", faults, "what goes wrong");
  v.group("truth", truth, "what is written beside the rawlog");
  v.group("expect", expect, "what SLAM must reach on it");
  v.group("expect_radar", expect_radar, "and on the same drive with a radar instead of the LiDAR");
}

Scenario loadScenario(const std::string& name_or_file, const std::vector<std::string>& sets) {
  Scenario scenario;
  if (std::filesystem::is_regular_file(name_or_file)) {
    scenario.name = std::filesystem::path(name_or_file).stem().string();
    loadYaml(scenario, readFile(name_or_file, 1 << 20), name_or_file);
  } else {
    std::vector<std::string> names;
    const std::string* text = nullptr;
    for (const auto& [name, yaml] : embeddedFiles()) {
      if (!name.starts_with("scenarios/")) continue;
      const std::string shipped = name.substr(10);
      names.push_back(shipped);
      if (shipped == name_or_file || shipped.substr(0, shipped.find('_')) == name_or_file)
        text = &yaml, scenario.name = shipped;
    }
    if (text == nullptr)
      throw usageError("there is no scenario '{}'{} (and no such file); `scslam sim --list` shows the shipped ones",
                       name_or_file, didYouMean(name_or_file, names));
    loadYaml(scenario, *text, scenario.name);
  }
  for (const std::string& assignment : sets) setParam(scenario, assignment);
  return scenario;
}

std::vector<std::pair<std::string, std::string>> scenarioNames() {
  std::vector<std::pair<std::string, std::string>> result;
  for (const auto& [name, yaml] : embeddedFiles())
    if (name.starts_with("scenarios/")) {
      Scenario scenario;
      loadYaml(scenario, yaml, name);
      result.emplace_back(name.substr(10), scenario.summary);
    }
  return result;
}

}  // namespace scslam::sim
