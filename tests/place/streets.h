// Made-up streets and keyframes for the tests of the place recognisers.
#pragma once
#include <random>

#include "scslam/place/place_recogniser.h"
#include "support/support.h"

namespace scslam::test {

/// With parameters from YAML, e.g. "{rings: 10}".
inline std::unique_ptr<PlaceRecogniser> makeRecogniser(const std::string& name, const std::string& set = "") {
  auto params = Registry<PlaceRecogniser>::instance().find(name).defaults();
  if (!set.empty()) loadYaml(*params, set, "test");
  return Registry<PlaceRecogniser>::instance().create(name, *params, context());
}

/// A street of random boxes seen from `T_world_base`: surfaces of towers around, and the ground. `road_half_m` keeps
/// the towers off the x axis.
inline Cloud streetFrom(const Pose& T_world_base, unsigned seed, double road_half_m = 0) {
  std::mt19937 random(seed);
  const auto uniform = [&random](double lo, double hi) {
    return lo + (hi - lo) * static_cast<double>(random()) / 4294967296.0;
  };
  Cloud world;
  for (int tower = 0; tower < 60; ++tower) {
    const double cx = uniform(-60, 60), cy = uniform(-60, 60), top = uniform(1, 15), half = uniform(0.3, 4);
    const double y = cy + (cy < 0 ? -1 : 1) * (road_half_m > 0 ? road_half_m + half : 0);
    for (double z = 0; z < top; z += 0.5)
      for (double s = -half; s <= half; s += 0.4)
        for (const double side : {-half, half}) {
          world.push(static_cast<float>(cx + s), static_cast<float>(y + side), static_cast<float>(z));
          world.push(static_cast<float>(cx + side), static_cast<float>(y + s), static_cast<float>(z));
        }
  }
  for (double x = -60; x <= 60; x += 1.5)
    for (double y = -60; y <= 60; y += 1.5) world.push(static_cast<float>(x), static_cast<float>(y), 0);
  return transformed(world, T_world_base.inverse());
}

inline Keyframe keyframeAt(KeyframeId id, double travelled, const Pose& T_odom_base = Pose::Identity()) {
  Keyframe keyframe;
  keyframe.id = id, keyframe.travelled_m = travelled, keyframe.T_odom_base = T_odom_base;
  return keyframe;
}

/// Describes and stores.
inline void visit(PlaceRecogniser& recogniser, const Keyframe& keyframe, const Cloud& cloud) {
  const bool scans = recogniser.usesScans();
  recogniser.add(keyframe, scans ? recogniser.describe(keyframe, cloud) : Descriptor(), scans ? cloud : Cloud());
}

/// The points of `cloud` within +-half_deg of straight ahead.
inline Cloud frontOf(const Cloud& cloud, double half_deg) {
  Cloud front;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (std::abs(std::atan2(cloud.y[i], cloud.x[i])) < half_deg * M_PI / 180) front.pushFrom(cloud, i);
  return front;
}

}  // namespace scslam::test
