// The whole configuration of a run. YAML sections are named after the folders of the figure.
#pragma once
#include <map>
#include <memory>
#include <string>

#include "scslam/core/registry.h"
#include "scslam/graph/optimiser.h"
#include "scslam/keyframe/selector.h"
#include "scslam/odometry/odometry.h"
#include "scslam/place/place_recogniser.h"
#include "scslam/registration/loop_gates.h"
#include "scslam/registration/registration.h"
#include "scslam/sensor/preprocess.h"

namespace scslam {

/// A choice among the plug-ins of one interface, with a group of parameters for each of them.
template <class Interface>
struct PluginChoice {
  std::string name;
  std::map<std::string, std::unique_ptr<ParamSet>> params;

  explicit PluginChoice(std::string chosen) : name(std::move(chosen)) {
    for (const auto& plugin : Registry<Interface>::instance().names())
      params[plugin] = Registry<Interface>::instance().find(plugin).defaults();
  }
  PluginChoice(const PluginChoice& other) : name(other.name) {
    for (const auto& [plugin, values] : other.params) params[plugin] = values->clone();
  }
  PluginChoice& operator=(const PluginChoice& other) {
    PluginChoice copy(other);
    std::swap(name, copy.name);
    std::swap(params, copy.params);
    return *this;
  }
  void describe(ParamVisitor& v, const char* key, const char* doc) {
    v.field(key, name, doc, Registry<Interface>::instance().names());
    for (auto& [plugin, values] : params)
      v.group(plugin.c_str(), *values, Registry<Interface>::instance().find(plugin).summary.c_str());
  }
  std::unique_ptr<Interface> create(const PluginContext& context) const {
    return Registry<Interface>::instance().create(name, *params.at(name), context);
  }
};

struct OdometryParams : ParamSetOf<OdometryParams> {
  PluginChoice<Odometry> frontend{"voxel_icp"};
  void describe(ParamVisitor& v) override { frontend.describe(v, "frontend", "which odometry"); }
};

struct PlaceParams : ParamSetOf<PlaceParams> {
  PluginChoice<PlaceRecogniser> recogniser{"scan_context"};
  void describe(ParamVisitor& v) override { recogniser.describe(v, "recogniser", "which place recogniser"); }
};

struct RegistrationParams : ParamSetOf<RegistrationParams> {
  PluginChoice<Registration> method{"voxel_planes"};
  double submap_reach_m = 20;
  int submap_max_each_side = 10;
  double voxel_m = 0.3;
  LoopGateParams gates;
  void describe(ParamVisitor& visitor) override;
};

struct GraphParams : ParamSetOf<GraphParams> {
  OptimiserParams optimiser;
  double odometry_floor_m = 0.01, odometry_floor_deg = 0.05;
  double loop_floor_m = 0.05, loop_floor_deg = 0.2;
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
void loadConfig(SlamParams& params, const std::string& name_or_file);

}  // namespace scslam
