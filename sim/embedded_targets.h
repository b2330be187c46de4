#pragma once
#include <map>
#include <string>

namespace scslam::sim {

/// The shipped real sets by name without ".yaml" (compiled in from sim/targets/), to be read by loadRealismTarget().
const std::map<std::string, std::string>& embeddedTargets();

}  // namespace scslam::sim
