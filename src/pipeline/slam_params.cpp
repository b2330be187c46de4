#include "scslam/pipeline/slam_params.h"

#include <filesystem>

#include "scslam/core/embedded_configs.h"
#include "scslam/core/file.h"

namespace scslam {

void RegistrationParams::describe(ParamVisitor& v) {
  method.describe(v, "method", "which registration");
  v.field("submap_reach_m", submap_reach_m,
          "scans this far along the path around the matched place form the submap [m]", 0, 1000);
  v.field("submap_max_each_side", submap_max_each_side, "at most so many scans before and after it", 0, 1000);
  v.field("voxel_m", voxel_m, "scans are thinned to one point per voxel before loops are registered [m]", 0.01, 10);
  v.field("min_intensity", min_intensity, "loops are registered by points at least so strong (radar: power, 0 .. 255)",
          0, 1e6);
  v.field("steady_scans", steady_scans,
          "and that so many of the scans around show: not clutter, nor what moves (1: all points)", 1, 64);
  v.field("steady_m", steady_m, "how near a point of another scan must be for that [m]", 0.01, 100);
  v.group("gates", gates, "what a loop must show");
}

void GnssParams::describe(ParamVisitor& v) {
  v.field("enabled", enabled, "satellite fixes of the recording enter the graph");
  v.field("min_fixes", min_fixes, "fixes needed before their frame can be placed in the map", 3, 1000000);
  v.field("min_spread_m", min_spread_m, "root mean square of their distance from their mean, likewise [m]", 0.1, 1e6);
  v.field("solve_every", solve_every, "new fixes after which the graph is solved", 1, 1000000);
  v.field("floor_m", floor_m, "a fix is never trusted better than this, one sigma, level [m]", 1e-3, 1000);
  v.field("floor_up_m", floor_up_m, "and upwards [m]", 1e-3, 1000);
}

void GraphParams::describe(ParamVisitor& v) {
  v.group("optimiser", optimiser, "the solver");
  v.group("consistency", consistency, "which loops agree with each other");
  v.group("gnss", gnss, "satellite fixes");
  v.field("odometry_floor_m", odometry_floor_m,
          "odometry between keyframes is never trusted better than this, one sigma [m]", 1e-6, 10);
  v.field("odometry_floor_deg", odometry_floor_deg, "and this [deg]", 1e-6, 90);
  v.field("loop_floor_m", loop_floor_m, "a loop is never trusted better than this, one sigma [m]", 1e-6, 10);
  v.field("loop_floor_deg", loop_floor_deg, "and this [deg]", 1e-6, 90);
  v.field("loop_outliers", loop_outliers,
          "share of the matched points that may lie off the surface for that; with more, both grow with its square",
          1e-3, 1);
}

void SessionParams::describe(ParamVisitor& v) {
  v.field("checkpoint_every", checkpoint_every, "keyframes between two points a killed run can go on from", 1, 100000);
  v.field("cloud_cache_mb", cloud_cache_mb, "memory for scans read back from the session [MB]", 1, 1e6);
}

void SlamParams::describe(ParamVisitor& v) {
  v.group("radar", radar, "from a radar's power image to points");
  v.group("preprocess", preprocess, "what is done to a scan before anything else");
  v.group("odometry", odometry, "how did the robot move since the last scan");
  v.group("keyframe", keyframe, "when a scan becomes a place");
  v.group("place", place, "which earlier place does it look like");
  v.group("registration", registration, "the constraint between both, and the gates it must pass");
  v.group("graph", graph, "weights and solver of the pose graph");
  v.group("session", session, "the session folder");
}

void loadConfig(ParamSet& params, const std::string& name_or_file) {
  if (std::filesystem::is_regular_file(name_or_file)) {
    loadYaml(params, readFile(name_or_file, 1 << 20), name_or_file);
    return;
  }
  std::vector<std::string> shipped;
  for (const auto& [name, text] : embeddedConfigs())
    if (!name.starts_with("sensors/")) shipped.push_back(name);
  const auto found = embeddedConfigs().find(name_or_file);
  if (found == embeddedConfigs().end() || name_or_file.starts_with("sensors/"))
    throw usageError("no configuration file or shipped configuration is called '{}'{}", name_or_file,
                     didYouMean(name_or_file, shipped));
  loadYaml(params, found->second, name_or_file + ".yaml");
}

}  // namespace scslam
