// The whole configuration of a run. YAML sections are named after the folders of the figure.
#pragma once
#include <string>

#include "scslam/core/plugin_choice.h"
#include "scslam/graph/consistency.h"
#include "scslam/graph/optimiser.h"
#include "scslam/keyframe/selector.h"
#include "scslam/odometry/odometry.h"
#include "scslam/place/place_recogniser.h"
#include "scslam/registration/loop_gates.h"
#include "scslam/registration/registration.h"
#include "scslam/sensor/preprocess.h"
#include "scslam/sensor/radar_points.h"

namespace scslam {

struct OdometryParams : ParamSetOf<OdometryParams> {
  PluginChoice<Odometry> frontend{"voxel_icp"};
  void describe(ParamVisitor& v) override { frontend.describe(v, "frontend", "which odometry"); }
};

struct PlaceParams : ParamSetOf<PlaceParams> {
  /// Side by side: each one's candidates are verified. The first one's descriptors are what the session keeps.
  PluginList<PlaceRecogniser> recognisers{{"scan_context", "cart_context", "radius"}};
  bool look_again = true;
  void describe(ParamVisitor& v) override {
    recognisers.describe(v, "recognisers", "which place recognisers, side by side");
    v.field("look_again", look_again,
            "after the run, keyframes without a loop are asked once more, with all poses corrected");
  }
};

struct RegistrationParams : ParamSetOf<RegistrationParams> {
  PluginChoice<Registration> method{"voxel_planes"};
  double submap_reach_m = 20;
  int submap_max_each_side = 10;
  double voxel_m = 0.3;
  double min_intensity = 0;
  int steady_scans = 1;
  double steady_m = 0.7;
  LoopGateParams gates;
  void describe(ParamVisitor& visitor) override;
};

/// How satellite fixes count.
struct GnssParams : ParamSetOf<GnssParams> {
  bool enabled = true;
  int min_fixes = 10, solve_every = 20;
  double min_spread_m = 10;
  double floor_m = 0.3, floor_up_m = 0.6;
  void describe(ParamVisitor& visitor) override;
};

struct GraphParams : ParamSetOf<GraphParams> {
  OptimiserParams optimiser;
  ConsistencyParams consistency;
  GnssParams gnss;
  double odometry_floor_m = 0.005, odometry_floor_deg = 0.02;
  double loop_floor_m = 0.05, loop_floor_deg = 0.2, loop_outliers = 0.04;
  GraphParams() {
    optimiser.init = "file";   // online: odometry has placed the newest keyframe
    optimiser.robust = "dcs";  // the paper's s_jk
  }
  void describe(ParamVisitor& visitor) override;
};

struct SessionParams : ParamSetOf<SessionParams> {
  int checkpoint_every = 20;
  double cloud_cache_mb = 64;
  void describe(ParamVisitor& visitor) override;
};

struct SlamParams : ParamSetOf<SlamParams> {
  RadarParams radar;
  PreprocessParams preprocess;
  OdometryParams odometry;
  KeyframeParams keyframe;
  PlaceParams place;
  RegistrationParams registration;
  GraphParams graph;
  SessionParams session;
  void describe(ParamVisitor& visitor) override;
};

/// Layers a shipped configuration ("laser2d") or a file over `params`.
/// @throw usageError when neither exists (with the shipped names), or for what loadYaml refuses.
void loadConfig(ParamSet& params, const std::string& name_or_file);

}  // namespace scslam
