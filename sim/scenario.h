// A scenario: world, drive, sensors, faults and truth in one YAML file. sim/scenarios/*.yaml are shipped in the binary.
#pragma once
#include <string>
#include <vector>

#include "scslam/core/plugin_choice.h"
#include "sim/drive.h"
#include "sim/gnss.h"
#include "sim/imu.h"
#include "sim/lidar.h"
#include "sim/radar.h"
#include "sim/weather.h"
#include "sim/wheel_odometry.h"
#include "sim/world_generator.h"

namespace scslam::sim {

struct WorldParams : ParamSetOf<WorldParams> {
  PluginChoice<WorldGenerator> kind{"town"};
  int seed = 0;  ///< 0: the scenario's
  void describe(ParamVisitor& v) override;
};

struct LidarParams : ParamSetOf<LidarParams> {
  bool on = true;
  std::string sensor = "os1-64";                                         ///< shipped table or file
  std::vector<double> translation_m = {0, 0, 1.8}, rpy_deg = {0, 0, 0};  ///< T_base_sensor
  LidarEffects effects;
  void describe(ParamVisitor& v) override;
};

struct RadarParams : ParamSetOf<RadarParams> {
  bool on = false;
  std::string sensor = "cts350-x";                                     ///< shipped (sim/radars) or a file
  std::vector<double> translation_m = {0, 0, 2}, rpy_deg = {0, 0, 0};  ///< T_base_sensor
  bool png = false;  ///< also OUT.radar/<stamp in us>.png in Oxford's layout
  void describe(ParamVisitor& v) override;
  /// The table, mounted. @throw usageError for an unknown name.
  RadarModel model() const;
};

struct FaultParams : ParamSetOf<FaultParams> {
  double lost_scans = 0;          ///< share of scans that are missing
  double time_offset_s = 0;       ///< added to the scans' stamps
  double lost_rings = 0;          ///< share of rings that are dead
  std::vector<double> dirty_deg;  ///< azimuths behind dirt: from, to, …
  double dirty_loss = 0.9;        ///< share of their points that is lost
  std::vector<double> off_s;      ///< no sensor measures: from, to, … after the start of the drive
  bool off(double time_s) const;  ///< by off_s
  void describe(ParamVisitor& v) override;
};

struct TruthParams : ParamSetOf<TruthParams> {
  bool labels = false;   ///< OUT.labels/NNNNNN.label
  bool firings = false;  ///< OUT.firings.tum: a pose per column
  bool loops = true;     ///< OUT.loops.csv
  bool aliases = true;   ///< OUT.aliases.csv
  bool pictures = true;  ///< OUT.world.png, OUT.scan.png
  double place_every_m = 2;
  double min_travel_m = 20;
  void describe(ParamVisitor& v) override;
};

/// What SLAM on the scenario must reach: the bounds of the regression tests. Negative: not asked.
struct ExpectParams : ParamSetOf<ExpectParams> {
  bool slam = true;      ///< does SLAM run on it at all
  std::string config;    ///< `run -c`; empty: the default
  std::string odometry;  ///< `run --odometry`; empty: the configuration's
  double ate_max_m = -1, odometry_ate_max_m = -1, false_loops_max = 0, loops_min = -1, recall_min = -1;
  double z_rmse_max_m = -1, nees_max = 15, wished_ate_m = -1, wished_recall = -1;
  void describe(ParamVisitor& v) override;
};

struct Scenario : ParamSetOf<Scenario> {
  std::string name = "scenario", summary;
  int seed = 1;
  WorldParams world;
  DriveParams drive;
  LidarParams lidar;
  RadarParams radar;
  ImuModel imu;
  WheelOdometryModel wheels;
  GnssModel gnss;
  Weather weather;
  FaultParams faults;
  TruthParams truth;
  ExpectParams expect;
  ExpectParams expect_radar;  ///< of the same drive seen by the radar alone
  Scenario() {
    imu.enabled = gnss.enabled = false;
    expect_radar.slam = false;
    expect_radar.config = "radar";
  }
  void describe(ParamVisitor& v) override;
  std::uint64_t worldSeed() const { return static_cast<std::uint64_t>(world.seed != 0 ? world.seed : seed); }
};

/// A shipped name ("s01_loop", or its number "s01") or a file, then assignments ("drive.speed_mps=12").
/// @throw usageError as loadYaml and setParam do, or for an unknown name.
Scenario loadScenario(const std::string& name_or_file, const std::vector<std::string>& sets = {});
/// Shipped scenarios: name and summary, sorted by name.
std::vector<std::pair<std::string, std::string>> scenarioNames();

}  // namespace scslam::sim
